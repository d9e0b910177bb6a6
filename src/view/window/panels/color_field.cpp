#include <imgui.h>

#include <algorithm>

#include "src/base/looks/color_word.h"
#include "src/view/window/panels/panels.h"

namespace sluice {

std::optional<std::string> colorField(const std::array<double, 3>& rgb) {
  std::array<float, 3> shown{};
  std::ranges::transform(rgb, shown.begin(), [](double part) { return static_cast<float>(part); });
  if (!ImGui::ColorEdit3("##color", shown.data(),
                         ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel))
    return std::nullopt;
  // The colour becomes a word of the command line at once, so that the printed command gives the
  // same one.
  return colorWord(std::array<double, 3>{shown[0], shown[1], shown[2]});
}

}  // namespace sluice
