#include <imgui.h>

#include <array>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

struct Line {
  const char *keys, *does;
};
// Keys are read in keys.cpp and picture_pane.cpp; a key that is added there needs its line here.
constexpr std::array<Line, 31> kLines = {{
    {"drag", "turn the volume"},
    {"Shift drag, middle drag", "move it"},
    {"Ctrl drag, Q, E", "roll"},
    {"Alt drag", "look around from the eye"},
    {"right drag", "window (across) and level (up and down)"},
    {"wheel, +, -", "zoom, to the pointer"},
    {"double click", "centre the point under the pointer"},
    {"arrows", "turn"},
    {"W, S, A, D, PgUp, PgDn", "fly ahead, back, left, right, up, down"},
    {"1 2 3 4 5 6, 0", "front, back, left, right, top, bottom, three-quarter"},
    {"P", "perspective or parallel"},
    {"T, Shift T", "threshold up, down"},
    {"M", "mode: composite, maximum, minimum, average, attenuated, by depth"},
    {"L", "light"},
    {"G", "opacity by the gradient"},
    {"B", "background: none, black, white"},
    {"[, ]", "shorter, longer step between samples"},
    {"X", "clip box with handles, or none"},
    {"C", "cut here, a plane through the middle"},
    {"V", "slices"},
    {"N", "maps of pages and blocks"},
    {"H", "histogram linear or logarithmic"},
    {"O", "axes, scale and colours"},
    {"Space, comma, dot", "play, a step back, a step on"},
    {"K, Shift K", "key frame here, remove the last one"},
    {"F, Ctrl F", "play the film, write its frames (or cancel)"},
    {"Ctrl Z, Ctrl Y", "undo, redo"},
    {"Ctrl O", "open"},
    {"Ctrl S, Ctrl Shift S", "save picture, save view"},
    {"Ctrl plus, Ctrl minus", "larger, smaller font"},
    {"?, Esc, Ctrl Q", "this list, close what is open, end"},
}};

}  // namespace

void helpWindow(WindowState& window) {
  if (!window.panels.shows_help) return;
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Appearing, {0.5F, 0.5F});
  if (ImGui::Begin("keys", &window.panels.shows_help,
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse) &&
      ImGui::BeginTable("list", 2)) {
    for (const Line& line : kLines) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(line.keys);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(line.does);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace sluice
