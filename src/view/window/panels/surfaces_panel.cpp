// A row for each surface of a value: the value, its colour and opacity.
#include <fmt/format.h>
#include <imgui.h>

#include "src/view/state/editing/look_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// Whether the surface is to go.
bool row(WindowState& window, size_t index) {
  const LookOptions::Surface surface = window.state().look.surfaces[index];
  // The surface is a copy: the edit changes the state that the panel reads.
  const auto edit = [&](const auto& change) {
    window.edit([&](ViewState& next) { change(next.look.surfaces[index]); });
  };
  const bool goes = ImGui::Button("x");
  window.log.control(fmt::format("remove surface {}", index));
  ImGui::SameLine();
  const ShownLook& look = window.volume.look;
  // A surface that was just added is not in the picture yet.
  const bool is_drawn = index < look.surfaces.size();
  const Rgb rgb = is_drawn ? look.surfaces[index].rgb : colorAt(look, surface.value);
  if (const auto chosen = colorField(rgb))
    edit([&](LookOptions::Surface& next) { next.color = *chosen; });
  window.log.control(fmt::format("surface {} color", index));
  ImGui::SameLine();
  const auto range = window.valueRange();
  double value = surface.value;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderScalar("##value", ImGuiDataType_Double, &value, &range[0], &range[1],
                          "value %.5g"))
    edit([&](LookOptions::Surface& next) { next.value = value; });
  window.log.control(fmt::format("surface {} value", index));
  auto opacity = static_cast<float>(surface.opacity);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##opacity", &opacity, 0, 1, "opacity %.2f", ImGuiSliderFlags_AlwaysClamp))
    edit([&](LookOptions::Surface& next) { next.opacity = static_cast<double>(opacity); });
  window.log.control(fmt::format("surface {} opacity", index));
  return goes;
}

}  // namespace

void surfacesPanel(WindowState& window) {
  std::optional<size_t> gone;
  for (size_t i = 0; i < window.state().look.surfaces.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (row(window, i)) gone = i;
    ImGui::PopID();
  }
  // After the loop, which counts the rows.
  if (gone)
    window.edit([&](ViewState& next) {
      next.look.surfaces.erase(next.look.surfaces.begin() + static_cast<std::ptrdiff_t>(*gone));
    });
}

}  // namespace sluice
