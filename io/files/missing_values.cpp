#include "io/files/missing_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sluice {

std::string missingValuesNote(const std::string& name, std::span<const double> stored, double scale,
                              double offset) {
  std::vector<double> values;
  for (const double number : stored) {
    const double value = number * scale + offset;
    // Files often give _FillValue and missing_value for the same number.
    if (!std::isnan(value) && std::ranges::find(values, value) == values.end())
      values.push_back(value);
  }
  if (values.empty()) return "";
  return fmt::format(
      "{}: voxels of the value {:g} are missing ones by its attributes (_FillValue, "
      "missing_value); sluice draws them as values",
      name, fmt::join(values, " or "));
}

}  // namespace sluice
