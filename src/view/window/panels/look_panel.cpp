#include <imgui.h>

#include <array>

#include "src/view/state/editing/look_edit.h"
#include "src/view/state/editing/transfer_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

void thresholdSlider(WindowState& window) {
  const auto range = window.valueRange();
  const LookOptions& look = window.state().look;
  // A look without a threshold shows the value at which opacity begins.
  double threshold = look.threshold.value_or(range[0]);
  if (!look.threshold)
    for (const ShownLook::Opacity& point : window.volume.look.opacities) {
      if (point.opacity > 0) break;
      threshold = point.value;
    }
  ImGui::SetNextItemWidth(-1);
  // Doubles hold every value of 32-bit voxels, which floats do not.
  if (ImGui::SliderScalar("##threshold", ImGuiDataType_Double, &threshold, &range[0], &range[1],
                          look.threshold ? "threshold %.5g" : "threshold (%.5g)"))
    window.edit([&](ViewState& next) { next.look = withThreshold(next.look, threshold); });
  window.log.control("threshold");
}

void opacitySlider(WindowState& window) {
  const LookOptions& look = window.state().look;
  ImGui::BeginDisabled(!look.threshold);  // shown anyway: nothing below it moves
  auto opacity = static_cast<float>(look.opacity.value_or(0.05));
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##opacity", &opacity, 0.001F, 1, "opacity %.3f",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    window.edit([&](ViewState& next) { next.look.opacity = static_cast<double>(opacity); });
  window.log.control("opacity");
  ImGui::EndDisabled();
}

void modes(WindowState& window) {
  constexpr std::array kNames{"composite",          "maximum",         "minimum", "average",
                              "attenuated maximum", "maximum by depth"};
  int mode = static_cast<int>(window.state().look.mode);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::Combo("##mode", &mode, kNames.data(), static_cast<int>(kNames.size()))) {
    ViewState next = window.state();
    next.look.mode = static_cast<LookOptions::Mode>(mode);
    // Other modes use values alone; the ramp of a threshold belongs to the composite mode.
    window.change(next);
  }
  window.log.control("mode");
}

void maps(WindowState& window) {
  const LookOptions& look = window.state().look;
  // The map that is shown may be chosen by the library, so it comes from the printed look and not
  // from the state.
  const std::string shown = wordAfter(window.volume.look.options, "--map");
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##map", ("colours " + (shown.empty() ? "of the file" : shown)).c_str())) {
    for (const std::string& map : window.request.color_maps)
      if (ImGui::Selectable(map.c_str(), map == look.map))
        window.edit([&](ViewState& next) { next.look.map = map; });
    ImGui::EndCombo();
  }
  window.log.control("map");
}

// Whether matter takes light away, and distance.
void lightAround(WindowState& window) {
  ImGui::BeginDisabled(!window.volume.look.lit);
  const auto box = [&](const char* label, auto member) {
    bool is_on = (window.state().lighting.*member).value_or(0) > 0;
    if (ImGui::Checkbox(label, &is_on))
      window.edit([&](ViewState& next) {
        next.lighting.*member = is_on ? std::optional(1.0) : std::nullopt;
      });
    window.log.control(label);
  };
  box("shadows", &PictureOptions::Lighting::shadows);
  ImGui::SameLine();
  box("occlusion", &PictureOptions::Lighting::occlusion);
  ImGui::EndDisabled();
  ImGui::BeginDisabled(window.state().look.mode != LookOptions::Mode::kComposite);
  box("darker far away", &PictureOptions::Lighting::depth_cueing);
  ImGui::EndDisabled();
}

void newSurface(WindowState& window) {
  ImGui::BeginDisabled(!takesSurface(window.state().look, window.volume.look));
  if (ImGui::Button("add a surface"))
    window.edit([&](ViewState& next) { next.look = withSurface(next.look, window.valueRange()); });
  window.log.control("add a surface");
  ImGui::EndDisabled();
}

void light(WindowState& window) {
  // The light of an automatic look is the library's choice: the box shows the picture, and a click
  // makes the choice the user's.
  bool is_lit = window.volume.look.lit;
  if (ImGui::Checkbox("light", &is_lit))
    window.edit([&](ViewState& next) {
      next.look.light = is_lit ? LookOptions::Light::kOn : LookOptions::Light::kOff;
    });
  window.log.control("light");
  ImGui::SameLine();
  bool modulates = window.state().look.full_gradient.has_value();
  if (ImGui::Checkbox("by gradient", &modulates))
    window.edit([&](ViewState& next) {
      next.look.full_gradient = modulates ? std::optional(0.1) : std::nullopt;
    });
  window.log.control("modulate");
  ImGui::SameLine();
  ImGui::BeginDisabled(!modulates);
  auto full = static_cast<float>(window.state().look.full_gradient.value_or(0.1));
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##gradient", &full, 0.005F, 1, "full at %.3f",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    window.edit([&](ViewState& next) { next.look.full_gradient = static_cast<double>(full); });
  ImGui::EndDisabled();
}

void windowAndLevel(WindowState& window) {
  const auto all = window.valueRange();
  const auto range = colorsOf(window.state().look, all);
  const auto span = static_cast<float>(all[1] - all[0]);
  auto lo = static_cast<float>(range[0]), hi = static_cast<float>(range[1]);
  ImGui::SetNextItemWidth(-1);
  // The fields have no limits: a window may reach beyond the values, as one of a CT often does.
  if (ImGui::DragFloatRange2("##window", &lo, &hi, span / 300, 0, 0, "window %.5g", "to %.5g") &&
      lo != hi) {
    window.edit([&](ViewState& next) {
      next.look.range = std::array{static_cast<double>(lo), static_cast<double>(hi)};
    });
  }
  window.log.control("window");
}

}  // namespace

void lookPanel(WindowState& window) {
  thresholdSlider(window);
  opacitySlider(window);
  modes(window);
  maps(window);
  windowAndLevel(window);
  light(window);
  lightAround(window);
  ImGui::SameLine();
  newSurface(window);
  // A look without options is the one that the library chooses.
  if (ImGui::Button("chosen look")) {
    window.edit([&](ViewState& next) { next.look = LookOptions{}; });
  }
  window.log.control("chosen look");
  ImGui::SameLine();
  ImGui::BeginDisabled(!window.history.canUndo());
  if (ImGui::Button("undo")) undo(window);
  window.log.control("undo");
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::BeginDisabled(!window.history.canRedo());
  if (ImGui::Button("redo")) redo(window);
  window.log.control("redo");
  ImGui::EndDisabled();
}

}  // namespace sluice
