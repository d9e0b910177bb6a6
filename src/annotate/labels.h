// Numbers and units as people write them. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// The largest of 1, 2 and 5 times a power of ten that is at most `value`. Requires: value > 0.
double roundBelow(double value);

// Round values inside the range, about `count` of them, ascending; one if the range is a single
// value.
std::vector<double> ticks(ValueRange range, int count);

// The shortest text that tells ticks of this step apart: "0.25", "1200", "3e-07".
std::string tickLabel(double value, double step);

// "millimeter" -> "mm"; unchanged if it is no unit of length; "units" if it is empty.
std::string unitSymbol(const std::string& unit);

}  // namespace sluice
