#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/view/state/editing/look_edit.h"
#include "src/view/window/panels/overlay_text.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

constexpr float kLarge = 1.35F;  // times the font, for the status of the window

std::string unitOf(const VolumeInfo& info) {
  if (info.unit == "millimeter") return "mm";
  if (info.unit == "micrometer") return "um";
  if (info.unit == "meter") return "m";
  return info.unit;
}

void axes(const WindowState& window, const Area& area, ImDrawList& to) {
  const PlacedAxes view = axesOf(window.shown.picture.state.view);
  const std::string& frame = window.info().frame;
  // The letters of a patient's directions are shown only if the file says what its axes mean.
  const bool knows = frame == "RAS" || frame == "LPS";
  constexpr std::array kPlain{"x", "y", "z"};
  constexpr std::array kColors{IM_COL32(240, 100, 90, 255), IM_COL32(110, 210, 110, 255),
                               IM_COL32(110, 150, 255, 255)};
  const ImVec2 origin{area.x + 45, area.y + area.height - 62};
  for (size_t a = 0; a < 3; ++a) {
    Vec3d world{};
    world[static_cast<int>(a)] = 1;
    const ImVec2 end{origin.x + 30 * static_cast<float>(dot(world, view.right)),
                     origin.y - 30 * static_cast<float>(dot(world, view.up))};
    to.AddLine(origin, end, kColors[a], 2);
    overlayText(to, {end.x + 2, end.y - 7}, knows ? std::string(1, frame[a]) : kPlain[a],
                kColors[a]);
  }
}

void scaleBar(const WindowState& window, const Area& area, float pixels, ImDrawList& to) {
  const double unit =
      worldPerPixel(window.shown.picture.state.view, window.pane, window.volume.ground) *
      static_cast<double>(pixels);
  // 1, 2 or 5 of a power of ten, at most a fifth of the width.
  const double most = unit * static_cast<double>(area.width) / 5;
  const double power = std::pow(10, std::floor(std::log10(most)));
  const double length = most >= 5 * power ? 5 * power : most >= 2 * power ? 2 * power : power;
  const auto wide = static_cast<float>(length / unit);
  const ImVec2 from{area.x + area.width - 20 - wide, area.y + area.height - 14};
  to.AddLine(from, {from.x + wide, from.y}, kInk, 2);
  overlayText(to, {from.x, from.y - 18}, fmt::format("{:g} {}", length, unitOf(window.info())));
}

// The value under the pointer, in the picture or in a slice.
const std::optional<VoxelProbe>& readingOf(const WindowState& window) {
  const Pointer& pointer = window.pointer;
  return window.state().shows_slices && pointer.slice_value ? pointer.slice_value : pointer.value;
}

// Width for text in the upper left corner.
float besideBars(const WindowState& window, const Area& area, bool has_picture) {
  const float right =
      has_picture && window.panels.shows_axes ? colorBarsLeft(window, area) : area.x + area.width;
  return std::max(1.0F, right - area.x - 20);
}

// Returns the lower end. Requires: there is a value.
float value(const WindowState& window, const Area& area, float wrap, ImDrawList& to) {
  const float top = area.y + 10;
  const std::string words =
      readingText(window.volume.look, *readingOf(window), unitOf(window.info()));
  overlayText(to, {area.x + 10, top}, words, kInk, 1, wrap);
  return top + ImGui::CalcTextSize(words.c_str(), nullptr, false, wrap).y;
}

}  // namespace

void drawOverlays(WindowState& window, const Area& area, float pixels) {
  ImDrawList& to = *ImGui::GetWindowDrawList();
  const CornerText corner = cornerText(window);
  const float large = kLarge * ImGui::GetFontSize();
  if (!corner.text.empty())
    overlayText(to, {area.x + 10, area.y + area.height - large - 8}, corner.text,
                corner.is_final ? kInk : IM_COL32(255, 200, 110, 255),
                corner.is_final ? 1 : kLarge);
  // These overlays belong to the picture that is shown, which may be older than the one wished for.
  const bool has_picture = window.isOpen() && window.shown.picture.state.view.look_at.has_value();
  const bool has_value = has_picture && readingOf(window);
  const bool was_saved = WindowClock::now() < window.messages.saved_until;
  const float wrap = has_value || was_saved ? besideBars(window, area, has_picture) : 0;
  float below = area.y + 10 + ImGui::GetFontSize();
  if (has_value) below = value(window, area, wrap, to);
  if (was_saved) {
    overlayText(to, {area.x + 10, below + 4}, window.messages.saved, IM_COL32(150, 230, 150, 255),
                kLarge, wrap);
    // No event tells that the message has had its time.
    window.loop.wakeBy(window.messages.saved_until);
  }
  if (!has_picture) return;
  drawBoxHandles(window, area, pixels);
  if (!window.panels.shows_axes) return;
  axes(window, area, to);
  scaleBar(window, area, pixels, to);
  drawColorBars(window, area);
}

}  // namespace sluice
