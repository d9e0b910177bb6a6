#include <imgui.h>

#include <array>
#include <cmath>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// Named views: the desk places them, as it does when a volume is opened.
void namedViews(WindowState& window) {
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
    if (ImGui::Button(kViews[i].name)) showFrom(window, kViews[i].from);
    window.log.control(kViews[i].name);
  }
}

void projection(WindowState& window) {
  const ViewOptions& view = window.state().view;
  bool is_perspective = view.projection == ViewOptions::Projection::kPerspective;
  if (ImGui::Checkbox("perspective", &is_perspective)) toggleProjection(window);
  window.log.control("perspective");
  ImGui::SameLine();
  ImGui::Checkbox("scale", &window.panels.shows_axes);
  ImGui::SameLine();
  bool slices = window.state().shows_slices;
  if (ImGui::Checkbox("slices", &slices))
    window.edit([&](ViewState& next) { next.shows_slices = slices; });
  window.log.control("slices");
}

void step(WindowState& window) {
  // An unset step follows the view and the levels that are shown. A number would stay when they
  // change.
  bool is_chosen = !window.state().step_vox;
  if (ImGui::Checkbox("chosen step", &is_chosen)) {
    window.edit(
        [&](ViewState& next) { next.step_vox = is_chosen ? std::nullopt : std::optional(1.0); });
  }
  window.log.control("chosen step");
  if (is_chosen) return;
  ImGui::SameLine();
  auto vox = static_cast<float>(*window.state().step_vox);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##step", &vox, 0.1F, 8, "step %.2f voxels",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    window.edit([&](ViewState& next) { next.step_vox = static_cast<double>(vox); });
  window.log.control("step");
}

void background(WindowState& window) {
  // Without a background, saved pictures keep their alpha, which no colour can stand for.
  bool has = window.state().background.has_value();
  if (ImGui::Checkbox("background", &has)) {
    window.edit([&](ViewState& next) {
      next.background = has ? std::optional(std::array{0.0F, 0.0F, 0.0F}) : std::nullopt;
    });
  }
  window.log.control("background");
  if (!has) return;
  ImGui::SameLine();
  std::array<float, 3> color = *window.state().background;
  if (ImGui::ColorEdit3("##background", color.data(), ImGuiColorEditFlags_NoInputs)) {
    ViewState next = window.state();
    // Rounded to six hexadecimal digits, so that the command line gives the same colour.
    for (float& channel : color) channel = static_cast<float>(std::lround(channel * 255)) / 255;
    next.background = color;
    window.change(next);
  }
}

}  // namespace

void viewPanel(WindowState& window) {
  namedViews(window);
  projection(window);
  step(window);
  background(window);
}

}  // namespace sluice
