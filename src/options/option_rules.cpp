#include "src/options/option_rules.h"

#include <array>

namespace sluice {
namespace {

// Labels have opacities of their own. Points given with a file replace those in the file.
constexpr std::array kApart = std::to_array<OptionPair>({
    {"--threshold", "--transfer"},
    {"--threshold", "--opacities"},
    {"--opacities", "--opacity"},
    {"--threshold", "--labels"},
    {"--threshold", "--labels-table"},
    {"--threshold", "--label"},
    {"--transfer", "--labels"},
    {"--transfer", "--labels-table"},
    {"--transfer", "--label"},
    {"--opacities", "--labels"},
    {"--opacities", "--labels-table"},
    {"--opacities", "--label"},
    {"--iso", "--labels"},
    {"--iso", "--labels-table"},
    {"--iso", "--label"},
    {"--no-shade", "--shade"},
    {"--eye", "--view"},
    {"--eye", "--azimuth"},
    {"--eye", "--elevation"},
    {"--eye", "--fit"},
    {"--level", "--pixel-error"},
    {"--level", "--max-bytes"},
    {"--level", "--keep-thin"},
});

constexpr std::array kNeeds = std::to_array<OptionPair>({
    {"--eye", "--target"},
    {"--target", "--eye"},
    {"--full-gradient", "--modulate"},
});

}  // namespace

std::span<const OptionPair> optionsApart() {
  return kApart;
}

std::span<const OptionPair> optionNeeds() {
  return kNeeds;
}

}  // namespace sluice
