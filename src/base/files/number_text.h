// A finite number that is all of a text.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace sluice {

// nullopt: the text is no number, more than one, or not finite.
inline std::optional<double> numberOf(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [read, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || read != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace sluice
