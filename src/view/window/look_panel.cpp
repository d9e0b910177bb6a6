#include <imgui.h>

#include <array>

#include "src/view/transfer_edit.h"
#include "src/view/window/panels.h"

namespace sluice {
namespace {

void thresholdSlider(Sitting& sitting) {
  const auto range = sitting.valueRange();
  const LookOptions& look = sitting.state().look;
  // Of a look without one, where something begins to show.
  double threshold = look.threshold.value_or(range[0]);
  if (!look.threshold)
    for (const ShownLook::Opacity& point : sitting.look.opacities) {
      if (point.opacity > 0) break;
      threshold = point.value;
    }
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderScalar("##threshold", ImGuiDataType_Double, &threshold, &range[0], &range[1],
                          look.threshold ? "threshold %.5g" : "threshold (%.5g)")) {
    ViewState next = sitting.state();
    next.look = withThreshold(next.look, threshold, range);
    sitting.change(next);
  }
  sitting.log.control("threshold");
}

void opacitySlider(Sitting& sitting) {
  const LookOptions& look = sitting.state().look;
  if (!look.threshold) return;
  auto opacity = static_cast<float>(look.opacity.value_or(0.05));
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##opacity", &opacity, 0.001F, 1, "opacity %.3f",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
    ViewState next = sitting.state();
    next.look.opacity = static_cast<double>(opacity);
    sitting.change(next);
  }
  sitting.log.control("opacity");
}

void modes(Sitting& sitting) {
  constexpr std::array kNames{"composite", "maximum", "minimum", "average"};
  int mode = static_cast<int>(sitting.state().look.mode);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::Combo("##mode", &mode, kNames.data(), static_cast<int>(kNames.size()))) {
    ViewState next = sitting.state();
    next.look.mode = static_cast<LookOptions::Mode>(mode);
    // Of values alone: the ramp of a threshold is of the composite mode.
    sitting.change(next);
  }
  sitting.log.control("mode");
}

void maps(Sitting& sitting) {
  const LookOptions& look = sitting.state().look;
  const std::string shown = wordAfter(sitting.look.options, "--map");
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##map", ("colours " + (shown.empty() ? "of the file" : shown)).c_str())) {
    for (const std::string& map : sitting.request.color_maps)
      if (ImGui::Selectable(map.c_str(), map == look.map)) {
        ViewState next = sitting.state();
        next.look.map = map;
        sitting.change(next);
      }
    ImGui::EndCombo();
  }
  sitting.log.control("map");
}

void light(Sitting& sitting) {
  bool is_lit = sitting.look.lit;
  if (ImGui::Checkbox("light", &is_lit)) {
    ViewState next = sitting.state();
    next.look.light = is_lit ? LookOptions::Light::kOn : LookOptions::Light::kOff;
    sitting.change(next);
  }
  sitting.log.control("light");
  ImGui::SameLine();
  bool modulates = sitting.state().look.full_gradient.has_value();
  if (ImGui::Checkbox("by gradient", &modulates)) {
    ViewState next = sitting.state();
    next.look.full_gradient = modulates ? std::optional(0.1) : std::nullopt;
    sitting.change(next);
  }
  sitting.log.control("modulate");
  if (!modulates) return;
  auto full = static_cast<float>(*sitting.state().look.full_gradient);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##gradient", &full, 0.005F, 1, "full at %.3f of the range a voxel",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
    ViewState next = sitting.state();
    next.look.full_gradient = static_cast<double>(full);
    sitting.change(next);
  }
}

void windowAndLevel(Sitting& sitting) {
  const auto all = sitting.valueRange();
  const auto range = sitting.state().look.range.value_or(all);
  const auto span = static_cast<float>(all[1] - all[0]);
  auto lo = static_cast<float>(range[0]), hi = static_cast<float>(range[1]);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::DragFloatRange2("##window", &lo, &hi, span / 300, 0, 0, "window %.5g", "to %.5g") &&
      lo != hi) {
    ViewState next = sitting.state();
    next.look.range = std::array{static_cast<double>(lo), static_cast<double>(hi)};
    sitting.change(next);
  }
  sitting.log.control("window");
}

}  // namespace

void lookPanel(Sitting& sitting) {
  thresholdSlider(sitting);
  opacitySlider(sitting);
  modes(sitting);
  maps(sitting);
  windowAndLevel(sitting);
  light(sitting);
  if (ImGui::Button("chosen look")) {
    ViewState next = sitting.state();
    next.look = LookOptions{};
    sitting.change(next);
  }
  sitting.log.control("chosen look");
  ImGui::SameLine();
  ImGui::BeginDisabled(!sitting.history.canUndo());
  if (ImGui::Button("undo")) sitting.history.undo();
  sitting.log.control("undo");
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::BeginDisabled(!sitting.history.canRedo());
  if (ImGui::Button("redo")) sitting.history.redo();
  sitting.log.control("redo");
  ImGui::EndDisabled();
}

}  // namespace sluice
