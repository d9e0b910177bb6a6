#include <fmt/format.h>
#include <imgui.h>

#include "src/view/window/panels.h"

namespace sluice {

void timePanel(Sitting& sitting) {
  const int64_t steps = sitting.info().time_steps;
  int64_t time = sitting.state().time;
  const int64_t first = 0, last = steps - 1;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderScalar("##time", ImGuiDataType_S64, &time, &first, &last, "step %lld",
                          ImGuiSliderFlags_AlwaysClamp)) {
    ViewState next = sitting.state();
    next.time = time;
    sitting.history.replace(next);
  }
  sitting.log.control("time");
  if (ImGui::Button(sitting.is_playing ? "pause" : "play"))
    sitting.is_playing = !sitting.is_playing;
  sitting.log.control("play");
  ImGui::SameLine();
  auto rate = static_cast<float>(sitting.steps_per_second);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##rate", &rate, 0.5F, 60, "%.1f steps a second",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    sitting.steps_per_second = static_cast<double>(rate);
  if (!sitting.is_playing || sitting.achieved_steps <= 0) return;
  if (sitting.achieved_steps < 0.9 * sitting.steps_per_second)
    ImGui::TextColored(
        {1, 0.8F, 0.4F, 1}, "%s",
        fmt::format("reading and drawing cannot keep up: {:.1f} of {:.1f} steps a second",
                    sitting.achieved_steps, sitting.steps_per_second)
            .c_str());
  else
    ImGui::TextDisabled("%.1f steps a second", sitting.achieved_steps);
}

}  // namespace sluice
