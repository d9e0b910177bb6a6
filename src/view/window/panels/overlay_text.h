// Text over the picture.
#pragma once

#include <imgui.h>

#include <string>

namespace sluice {

inline constexpr ImU32 kInk = IM_COL32(235, 235, 235, 255), kShade = IM_COL32(0, 0, 0, 160);

// Draws text that is readable over any picture. `scale`: times the font. `wrap`: width of a line;
// 0: there is one line.
inline void overlayText(ImDrawList& to, ImVec2 at, const std::string& words, ImU32 color = kInk,
                        float scale = 1, float wrap = 0) {
  const float size = ImGui::GetFontSize() * scale;
  to.AddText(nullptr, size, {at.x + 1, at.y + 1}, kShade, words.c_str(), nullptr, wrap);
  to.AddText(nullptr, size, at, color, words.c_str(), nullptr, wrap);
}

}  // namespace sluice
