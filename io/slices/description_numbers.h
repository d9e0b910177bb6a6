// Fields of a TIFF's description, and the numbers in them.
#pragma once

#include <fmt/format.h>

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
#include "src/base/values/letter_case.h"
#include "src/base/values/text_parts.h"

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

// The unit of a time as a description abbreviates it.
inline std::string timeUnit(std::string_view text) {
  static constexpr std::pair<std::string_view, const char*> kUnits[] = {{"", "second"},
                                                                        {"s", "second"},
                                                                        {"sec", "second"},
                                                                        {"ms", "millisecond"},
                                                                        {"msec", "millisecond"},
                                                                        {"us", "microsecond"},
                                                                        {"\u00b5s", "microsecond"},
                                                                        {"\u03bcs", "microsecond"},
                                                                        {"\\u00b5s", "microsecond"},
                                                                        {"ns", "nanosecond"},
                                                                        {"min", "minute"},
                                                                        {"h", "hour"},
                                                                        {"d", "day"}};
  const std::string unit(trimmed(text));
  for (const auto& [brief, name] : kUnits)
    if (unit == brief || lowercase(unit) == brief) return name;
  return printable(unit);
}

// Sets the time between frames as a description gives it under `name`, if there are several.
inline void setFrameTimes(const Fields& fields, std::string_view name, std::string_view unit_name,
                          PageOrder& order) {
  const std::string text = fieldOf(fields, name);
  const std::string_view said = trimmed(text);
  if (said.empty() || order.frames < 2) return;
  const std::optional<double> step = numberOf(said);
  if (!step || *step <= 0) {
    order.notes.push_back(fmt::format(
        "its description has a {} of {}, which is no time between frames: it is left out", name,
        printable(std::string(said))));
    return;
  }
  order.times = TimeAxis{*step, 0, timeUnit(fieldOf(fields, unit_name))};
}

}  // namespace sluice
