// Numbers on the command line: one parser for all options, which know their ranges and print them.
// Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include "src/base/values/number_range.h"

namespace sluice {

// The whole of `text` as a finite number; nullopt otherwise, even if it only does not fit the type.
std::optional<double> parseReal(const std::string& text);
std::optional<int64_t> parseWhole(const std::string& text);
std::optional<uint64_t> parseUnsigned(const std::string& text);
// "512M": a size above 0, in the words of kByteSizes.
std::optional<int64_t> parseByteSize(const std::string& text);
inline constexpr const char* kByteSizes = "a size above 0 and below 8 EiB, as in 512M or 4G";
// "0.5", "1s" or "500ms".
std::optional<double> parseSeconds(std::string text);

// "a number above 0, up to 1", "a whole number from 1 to 100000"; an end that is the type's own is
// left out.
std::string rangeText(const NumberRange<double>& range);
std::string rangeText(const NumberRange<int64_t>& range);
std::string rangeText(const NumberRange<uint64_t>& range);
// The number as people write it: 0.05, 30, 1e+12.
std::string numberText(double number);

// A number of the range; nullopt otherwise.
template <class Number>
std::optional<Number> parseIn(const std::string& text, const NumberRange<Number>& range) {
  std::optional<Number> number;
  if constexpr (std::is_same_v<Number, double>) {
    number = parseReal(text);
  } else if constexpr (std::is_same_v<Number, uint64_t>) {
    number = parseUnsigned(text);
  } else {
    number = parseWhole(text);
  }
  return number && range.holds(*number) ? number : std::nullopt;
}

}  // namespace sluice
