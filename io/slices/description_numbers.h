// Fields of a TIFF's description, and the numbers in them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "io/slices/page_order.h"
#include "src/base/files/number_text.h"

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

}  // namespace sluice
