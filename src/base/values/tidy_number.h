// Numbers that a calculation made, for options and reports that people read and give again.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string>

namespace sluice {

// The number without the digits that rounding has left: 0.75 for 0.7500000000000001, and 0.1 for
// the float next to it. It differs by less than floats do.
inline double tidyNumber(double value) {
  if (!std::isfinite(value)) return value;
  const auto as_float = static_cast<float>(value);
  const bool is_float = std::isfinite(as_float) && double{as_float} == value;
  const std::string text = is_float ? fmt::format("{}", as_float) : fmt::format("{:.12g}", value);
  return std::strtod(text.c_str(), nullptr);
}

}  // namespace sluice
