#include "src/annotate/labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "src/base/error.h"

namespace sluice {

double roundBelow(double value) {
  SLUICE_CHECK(value > 0);
  const double power = std::pow(10, std::floor(std::log10(value)));
  // A little below counts, since powers of ten are not exact.
  const double digits = value / power * (1 + 1e-9);
  return power * (digits >= 5 ? 5 : digits >= 2 ? 2 : 1);
}

std::vector<double> ticks(ValueRange range, int count) {
  const double span = range.hi - range.lo;
  if (!(span > 0)) return {range.lo};
  const double step = roundBelow(span / std::max(count - 1, 1));
  std::vector<double> values;
  const double slack = 1e-6 * step;
  for (double i = std::ceil((range.lo - slack) / step); i * step <= range.hi + slack; ++i)
    values.push_back(i * step);
  // Steps of 1, 2 and 5 are up to 2.5 apart: too many become every other.
  while (static_cast<int>(values.size()) > count + 2) {
    std::vector<double> fewer;
    for (const double value : values)
      if (std::llround(value / step) % 2 == 0) fewer.push_back(value);
    if (fewer.size() == values.size() || fewer.size() < 2) break;
    values = std::move(fewer);
  }
  return values;
}

std::string tickLabel(double value, double step) {
  if (std::abs(value) < 1e-9 * step) return "0";
  const double size = std::max(std::abs(value), step);
  if (size >= 1e6 || size < 1e-4) return fmt::format("{:.3g}", value);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value, std::min(decimals, 9));
}

std::string unitSymbol(const std::string& unit) {
  constexpr std::array<std::pair<const char*, const char*>, 18> kSymbols{{{"meter", "m"},
                                                                          {"metre", "m"},
                                                                          {"centimeter", "cm"},
                                                                          {"centimetre", "cm"},
                                                                          {"millimeter", "mm"},
                                                                          {"millimetre", "mm"},
                                                                          {"micrometer", "µm"},
                                                                          {"micrometre", "µm"},
                                                                          {"micron", "µm"},
                                                                          {"um", "µm"},
                                                                          {"nanometer", "nm"},
                                                                          {"nanometre", "nm"},
                                                                          {"angstrom", "Å"},
                                                                          {"kilometer", "km"},
                                                                          {"kilometre", "km"},
                                                                          {"inch", "in"},
                                                                          {"foot", "ft"},
                                                                          {"", "units"}}};
  for (const auto& [name, symbol] : kSymbols)
    if (unit == name || unit == std::string(name) + "s") return symbol;
  return unit;
}

}  // namespace sluice
