#include "src/device/shading/integrated_look.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sluice {
namespace {

// The greatest sum, a little below that of the type.
constexpr double kMostSum = 2.1e9;
// How far rounding moves a value at the most, in parts of it.
constexpr double kRounding = 16.0 / (1 << 23);

// Extinction times red, green, blue and 1.
std::array<double, 4> extinctionOf(const LookUp& look_up, size_t entry) {
  const float* rgba = &look_up.rgba[4 * entry];
  const double opacity = rgba[3];
  const double extinction =
      opacity < 1 ? std::min(-std::log2(1 - std::max(opacity, 0.0)), kMostExtinctionBits)
                  : kMostExtinctionBits;
  return {extinction * rgba[0], extinction * rgba[1], extinction * rgba[2], extinction};
}

}  // namespace

IntegratedLook integratedLook(const LookUp& look_up) {
  const size_t entries = look_up.rgba.size() / 4, steps = std::max<size_t>(entries, 2) - 1;
  // Sums in double precision, and their greatest number.
  std::vector<std::array<double, 4>> sums(steps + 1), alone;
  double most = 0;
  for (size_t i = 0; i < steps; ++i) {
    const std::array<double, 4> lower = extinctionOf(look_up, i);
    const std::array<double, 4> upper = extinctionOf(look_up, std::min(i + 1, entries - 1));
    for (size_t c = 0; c < 4; ++c) {
      // The look is linear between two entries, so that the trapezoid is exact.
      sums[i + 1][c] = sums[i][c] + (lower[c] + upper[c]) / 2;
      most = std::max(most, sums[i + 1][c]);
    }
  }
  for (size_t i = 0; i <= steps; ++i) {
    alone.push_back(extinctionOf(look_up, std::min(i, entries - 1)));
    for (const double number : alone.back()) most = std::max(most, number);
  }
  IntegratedLook look;
  // The greatest number uses the whole range of the type, so that small differences keep the most
  // digits.
  const double scale = most > 0 ? kMostSum / most : 1;
  look.unit = 1 / scale;
  for (const auto* row : {&sums, &alone})
    for (const std::array<double, 4>& numbers : *row)
      for (const double number : numbers)
        look.sums.push_back(static_cast<int32_t>(std::llround(number * scale)));
  const ValueRange range = look_up.device_range;
  // A volume of one value has a single entry, whatever the value.
  if (range.hi > range.lo)
    look.entries_a_value = static_cast<double>(entries - 1) / (range.hi - range.lo);
  look.first = -range.lo * look.entries_a_value;
  const double rounding = kRounding * std::max(std::abs(range.lo), std::abs(range.hi));
  look.one_value = std::clamp(rounding * look.entries_a_value, look.one_value, 1.0);
  look.near_entry = look.one_value / 8;
  return look;
}

}  // namespace sluice
