#include "src/base/looks/color_word.h"

#include <fmt/format.h>

#include <cmath>

namespace sluice {

std::string colorWord(std::span<const double> rgb) {
  std::string word;
  for (const double part : rgb)
    word += fmt::format("{:02x}", std::lround(std::clamp(part, 0.0, 1.0) * 255));
  return word;
}

}  // namespace sluice
