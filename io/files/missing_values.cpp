#include "io/files/missing_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace sluice {
namespace {

bool isFloat(VoxelType type) {
  return type == VoxelType::kF32 || type == VoxelType::kF64;
}

}  // namespace

std::vector<double> blankedNumbers(VoxelType type, std::span<const double> missing) {
  std::vector<double> numbers;
  if (!isFloat(type)) return numbers;
  for (const double number : missing)
    if (!std::isnan(number)) numbers.push_back(number);
  return numbers;
}

void blank(VoxelType type, std::span<const double> numbers, std::span<std::byte> voxels) {
  if (numbers.empty()) return;
  visitVoxelType(type, [&](auto tag) {
    using T = decltype(tag);
    if constexpr (std::is_floating_point_v<T>) {
      std::vector<T> wanted;
      for (const double number : numbers)
        // Beyond the type's range it would be an infinity, which is a value.
        if (std::isinf(number) || std::abs(number) <= double{std::numeric_limits<T>::max()})
          wanted.push_back(static_cast<T>(number));
      constexpr T kNan = std::numeric_limits<T>::quiet_NaN();
      for (size_t at = 0; at + sizeof(T) <= voxels.size(); at += sizeof(T)) {
        T value;
        std::memcpy(&value, voxels.data() + at, sizeof value);
        if (std::ranges::find(wanted, value) != wanted.end())
          std::memcpy(voxels.data() + at, &kNan, sizeof kNan);
      }
    }
  });
}

std::string missingValuesNote(std::span<const double> missing, const VolumeLayout& layout,
                              std::string_view said_by) {
  if (isFloat(layout.type)) return "";
  std::vector<std::string> values;
  for (const double number : missing) {
    const std::string value =
        fmt::format("{:g}", number * layout.value_scale + layout.value_offset);
    // Files often give _FillValue and missing_value for the same number.
    if (std::ranges::find(values, value) == values.end()) values.push_back(value);
  }
  if (values.empty()) return "";
  return fmt::format(
      "voxels of the value {} stand for missing values in the file ({}); sluice draws them as "
      "values",
      fmt::join(values, " or "), said_by);
}

std::string invalidValuesNote(std::optional<double> least, std::optional<double> greatest,
                              const VolumeLayout& layout) {
  std::vector<std::string> parts;
  const auto add = [&](double stored, bool is_below) {
    // A negative scale turns them round.
    parts.push_back(fmt::format("{} {:g}", is_below == (layout.value_scale > 0) ? "below" : "above",
                                stored * layout.value_scale + layout.value_offset));
  };
  visitVoxelType(layout.type, [&](auto tag) {
    using Limits = std::numeric_limits<decltype(tag)>;
    if (least && *least > static_cast<double>(Limits::lowest())) add(*least, true);
    if (greatest && *greatest < static_cast<double>(Limits::max())) add(*greatest, false);
  });
  if (parts.empty()) return "";
  return fmt::format(
      "values {} are invalid by the file (valid_range, valid_min, valid_max); sluice draws them as "
      "values",
      fmt::join(parts, " or "));
}

}  // namespace sluice
