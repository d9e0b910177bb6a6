// Fields of a TIFF's description, and the numbers in them.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "io/files/time_unit.h"
#include "io/slices/page_order.h"
#include "src/base/files/json_field.h"
#include "src/base/files/number_text.h"
#include "src/base/sources/volume_times.h"
#include "src/base/values/text_parts.h"

namespace sluice {

// ImageJ's "key=value" lines, or the attributes of an XML element.
using Fields = std::map<std::string, std::string, std::less<>>;

// Empty: there is no such field, or it is empty.
inline std::string fieldOf(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

// The number that all of a field is, nullopt if there is none. XML allows white space around it.
template <class T>
std::optional<T> numberOfField(const Fields& fields, std::string_view name) {
  return numberIn<T>(trimmed(fieldOf(fields, name)));
}

// A count of 1 or more; 1 if the field is missing or makes no sense.
inline int64_t countOf(const Fields& fields, std::string_view name) {
  const auto count = numberOfField<int64_t>(fields, name);
  return count && *count >= 1 && *count <= kMostPlanes ? *count : 1;
}

// Positions beyond this are taken for damage.
inline constexpr double kFarthest = 1e15;

// The length when it makes sense as one, else 1.
inline double lengthOr1(std::optional<double> length) {
  constexpr double kLeast = 1e-15, kMost = 1e15;
  return length && *length >= kLeast && *length <= kMost ? *length : 1;
}

// Sets the time between frames as a description gives it under `name`, if there are several.
// `who`: "its OME description".
inline void setFrameTimes(std::string_view who, const Fields& fields, std::string_view name,
                          std::string_view unit_name, PageOrder& order) {
  const std::string text = fieldOf(fields, name);
  const std::string_view said = trimmed(text);
  if (said.empty() || order.frames < 2) return;
  const std::string unit_text = fieldOf(fields, unit_name);
  const std::string_view unit = trimmed(unit_text);
  TimeAxis times{.unit = unit.empty() ? "second" : timeUnit(unit)};
  const std::optional<double> step = numberOf(said);
  if (step && *step > 0)
    times.step = *step;
  else
    order.notes.push_back(
        fmt::format("{} has a {} of {}, which is no time between frames: {:g} {} is used", who,
                    name, printable(said), times.step, times.unit));
  order.times = std::move(times);
}

}  // namespace sluice
