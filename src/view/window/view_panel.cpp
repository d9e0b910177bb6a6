#include <imgui.h>

#include <array>
#include <cmath>

#include "src/view/window/panels.h"

namespace sluice {
namespace {

// Named views: the desk places them, as it does when a volume is opened.
void namedViews(Sitting& sitting) {
  struct Named {
    const char* name;
    ViewOptions::From from;
  };
  constexpr std::array<Named, 7> kViews = {{{"front", ViewOptions::From::kFront},
                                            {"back", ViewOptions::From::kBack},
                                            {"left", ViewOptions::From::kLeft},
                                            {"right", ViewOptions::From::kRight},
                                            {"top", ViewOptions::From::kTop},
                                            {"bottom", ViewOptions::From::kBottom},
                                            {"3/4", ViewOptions::From::kThreeQuarter}}};
  for (size_t i = 0; i < kViews.size(); ++i) {
    if (i % 4 != 0) ImGui::SameLine();
    if (ImGui::Button(kViews[i].name)) sitting.showFrom(kViews[i].from);
    sitting.log.control(kViews[i].name);
  }
}

void projection(Sitting& sitting) {
  const ViewOptions& view = sitting.state().view;
  bool is_perspective = view.projection == ViewOptions::Projection::kPerspective;
  if (ImGui::Checkbox("perspective", &is_perspective)) sitting.toggleProjection();
  sitting.log.control("perspective");
  ImGui::SameLine();
  ImGui::Checkbox("scale", &sitting.shows_axes);
  ImGui::SameLine();
  bool slices = sitting.state().shows_slices;
  if (ImGui::Checkbox("slices", &slices)) {
    ViewState next = sitting.state();
    next.shows_slices = slices;
    sitting.change(next);
  }
  sitting.log.control("slices");
}

void step(Sitting& sitting) {
  bool is_chosen = !sitting.state().step_vox;
  if (ImGui::Checkbox("chosen step", &is_chosen)) {
    ViewState next = sitting.state();
    next.step_vox = is_chosen ? std::nullopt : std::optional(1.0);
    sitting.change(next);
  }
  sitting.log.control("chosen step");
  if (is_chosen) return;
  ImGui::SameLine();
  auto vox = static_cast<float>(*sitting.state().step_vox);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##step", &vox, 0.1F, 8, "step %.2f voxels",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
    ViewState next = sitting.state();
    next.step_vox = static_cast<double>(vox);
    sitting.change(next);
  }
  sitting.log.control("step");
}

void background(Sitting& sitting) {
  bool has = sitting.state().background.has_value();
  if (ImGui::Checkbox("background", &has)) {
    ViewState next = sitting.state();
    next.background = has ? std::optional(std::array{0.0F, 0.0F, 0.0F}) : std::nullopt;
    sitting.change(next);
  }
  sitting.log.control("background");
  if (!has) return;
  ImGui::SameLine();
  std::array<float, 3> color = *sitting.state().background;
  if (ImGui::ColorEdit3("##background", color.data(), ImGuiColorEditFlags_NoInputs)) {
    ViewState next = sitting.state();
    // What six hexadecimal digits say, so that the command line says the same.
    for (float& channel : color) channel = static_cast<float>(std::lround(channel * 255)) / 255;
    next.background = color;
    sitting.change(next);
  }
}

}  // namespace

void viewPanel(Sitting& sitting) {
  namedViews(sitting);
  projection(sitting);
  step(sitting);
  background(sitting);
}

}  // namespace sluice
