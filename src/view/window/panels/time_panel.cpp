#include <fmt/format.h>
#include <imgui.h>

#include <cmath>

#include "src/view/window/panels/panels.h"

namespace sluice {

void timePanel(WindowState& window) {
  const int64_t steps = window.info().time_steps;
  int64_t time = window.state().time;
  const int64_t first = 0, last = steps - 1;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderScalar("##time", ImGuiDataType_S64, &time, &first, &last, "step %lld",
                          ImGuiSliderFlags_AlwaysClamp)) {
    ViewState next = window.state();
    next.time = time;
    // The step is no change to undo, as with the keys.
    window.history.replace(next);
  }
  window.log.control("time");
  if (ImGui::Button(window.series.is_playing ? "pause" : "play"))
    window.series.is_playing = !window.series.is_playing;
  window.log.control("play");
  ImGui::SameLine();
  auto rate = static_cast<float>(window.series.steps_per_second);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##rate", &rate, 0.5F, 60, "%.1f steps a second",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp) &&
      std::isfinite(rate))
    window.series.steps_per_second = static_cast<double>(rate);
  if (!window.series.is_playing || window.series.achieved_steps <= 0)
    return ImGui::TextDisabled(" ");  // keeps the following items in place
  // A tenth less is within what the clock of the loop allows.
  if (window.series.achieved_steps < 0.9 * window.series.steps_per_second)
    ImGui::TextColored({1, 0.8F, 0.4F, 1}, "%s",
                       fmt::format("too slow: {:.1f} of {:.1f} steps a second",
                                   window.series.achieved_steps, window.series.steps_per_second)
                           .c_str());
  else
    ImGui::TextDisabled("%.1f steps a second", window.series.achieved_steps);
}

}  // namespace sluice
