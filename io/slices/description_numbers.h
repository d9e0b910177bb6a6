// Fields of a TIFF's description, and the numbers in them.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "io/slices/page_order.h"
#include "src/base/files/json_field.h"
#include "src/base/files/number_text.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

// ImageJ's "key=value" lines, or the attributes of an XML element.
using Fields = std::map<std::string, std::string, std::less<>>;

// Empty: there is no such field, or it is empty.
inline std::string fieldOf(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

// A count of 1 or more; 1 if the field is missing or makes no sense.
inline int64_t countOf(const Fields& fields, std::string_view name) {
  const auto count = numberIn<int64_t>(fieldOf(fields, name));
  return count && *count >= 1 && *count <= kMostPlanes ? *count : 1;
}

// Positions beyond this are taken for damage.
inline constexpr double kFarthest = 1e15;

// The length when it makes sense as one, else 1.
inline double lengthOr1(std::optional<double> length) {
  constexpr double kLeast = 1e-15, kMost = 1e15;
  return length && *length >= kLeast && *length <= kMost ? *length : 1;
}

// The time between frames as a description gives it, in a unit as it abbreviates it; nullopt: none.
inline std::optional<TimeAxis> frameTimes(std::optional<double> step, std::string_view unit) {
  if (!step || !std::isfinite(*step) || *step <= 0) return std::nullopt;
  constexpr std::pair<std::string_view, const char*> kUnits[] = {
      {"s", "second"},       {"sec", "second"},
      {"ms", "millisecond"}, {"msec", "millisecond"},
      {"us", "microsecond"}, {"\u00b5s", "microsecond"},
      {"ns", "nanosecond"},  {"min", "minute"},
      {"h", "hour"},         {"d", "day"}};
  for (const auto& [brief, name] : kUnits)
    if (unit == brief) return TimeAxis{*step, 0, name};
  return TimeAxis{*step, 0, printable(std::string(unit))};
}

}  // namespace sluice
