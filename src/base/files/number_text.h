// The number that all of a text is.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace sluice {

// nullopt: the text is no number, more than one, or T cannot hold it. Takes no plus sign; "nan" and
// "inf" are numbers.
template <class T>
std::optional<T> numberIn(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [read, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || read != end) return std::nullopt;
  return value;
}

// The same for a finite number.
inline std::optional<double> numberOf(std::string_view text) {
  const auto value = numberIn<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace sluice
