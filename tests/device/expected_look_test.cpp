// Expected opacities and colours against sums over many values.
#include "src/device/shading/expected_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {
namespace {

constexpr ValueRange kRange{10, 250};
constexpr int kValues = 20000;

// Enough values to represent the distribution of expected_look.h, computed plainly.
std::vector<double> valuesOf(double mean, double spread, ValueRange range) {
  const SpreadValues d = spreadValues(mean, spread, range);
  std::vector<double> values;
  const auto add = [&](double share, double lo, double hi) {
    const auto count = std::llround(share * kValues);
    for (int64_t i = 0; i < count; ++i)
      values.push_back(lo +
                       (hi - lo) * (static_cast<double>(i) + 0.5) / static_cast<double>(count));
  };
  const double inner = 1 - d.at_ends, reach = d.down + d.up;
  const double below = reach > 0 ? d.up / reach : 0.5;
  add(inner * below, d.mean - d.down, d.mean);
  add(inner * (1 - below), d.mean, d.mean + d.up);
  const double low = (range.hi - d.mean) / (range.hi - range.lo);
  add(d.at_ends * low, range.lo, range.lo);
  add(d.at_ends * (1 - low), range.hi, range.hi);
  return values;
}

double meanOf(const std::vector<double>& values, const std::function<double(double)>& f) {
  double sum = 0;
  for (const double value : values) sum += f(value);
  return sum / static_cast<double>(values.size());
}

// Calls visit(mean, spread) for means and the spreads that values of the range may have with them.
void eachSpread(const std::function<void(double, double)>& visit) {
  for (const double mean : {10.5, 14.0, 60.0, 130.0, 201.0, 249.0})
    for (const double share : {0.01, 0.1, 0.3, 0.6, 0.9, 1.0})
      visit(mean, 2 * share * std::sqrt((mean - kRange.lo) * (kRange.hi - mean)));
}

TEST(ExpectedLook, valuesHaveTheMeanAndTheSpread) {
  eachSpread([](double mean, double spread) {
    const std::vector<double> values = valuesOf(mean, spread, kRange);
    const double found = meanOf(values, [](double v) { return v; });
    EXPECT_NEAR(found, mean, 0.02);
    const double variance = meanOf(values, [&](double v) { return (v - found) * (v - found); });
    EXPECT_NEAR(2 * std::sqrt(variance), spread, 0.01 * spread + 0.02);
    EXPECT_GE(std::ranges::min(values), kRange.lo - 1e-9);
    EXPECT_LE(std::ranges::max(values), kRange.hi + 1e-9);
    const ValueRange range = spreadRange(mean, spread, kRange);
    EXPECT_LE(range.lo, std::ranges::min(values) + 1e-9);
    EXPECT_GE(range.hi, std::ranges::max(values) - 1e-9);
  });
}

TEST(ExpectedLook, theGreatestSpreadIsTwoValues) {
  for (const double share : {0.001, 0.05, 0.5, 0.9}) {
    const double mean = kRange.lo + share * (kRange.hi - kRange.lo);
    const double spread = 2 * std::sqrt(share * (1 - share)) * (kRange.hi - kRange.lo);
    EXPECT_NEAR(spreadValues(mean, spread, kRange).at_ends, 1, 1e-6);
    // Rounding moves the mean away from the one that the spread needs.
    EXPECT_NEAR(spreadValues(kRange.lo, spread, kRange).mean, std::min(mean, 2 * kRange.hi - mean),
                share <= 0.5 ? 1e-6 : 240);
  }
  EXPECT_EQ(spreadValues(77, 0, kRange).down, 0);
  EXPECT_EQ(spreadValues(77, 0, kRange).up, 0);
  EXPECT_EQ(spreadValues(3, 0, {5, 5}).mean, 5) << "a volume of one value";
}

LookUp lookUpOf(const std::function<std::array<float, 4>(double)>& rgba) {
  constexpr int kEntries = 4096;
  LookUp look_up;
  look_up.device_range = kRange;
  for (int i = 0; i < kEntries; ++i)
    for (const float channel : rgba(kRange.lo + (kRange.hi - kRange.lo) * i / (kEntries - 1)))
      look_up.rgba.push_back(channel);
  return look_up;
}

// Every entry of some rows against the sum over the values that it stands for.
void expectSums(const LookUp& look_up, const std::function<std::array<float, 4>(double)>& rgba,
                double tolerance) {
  const ExpectedLook look = expectedLook(look_up, kRange);
  ASSERT_EQ(look.rgba.size(), size_t{4} * static_cast<size_t>(look.entries * look.rows));
  const double span = kRange.hi - kRange.lo;
  for (const int row : {2, look.rows / 3, look.rows - 5, look.rows - 1})
    for (int entry = 3; entry < look.entries; entry += 37) {
      const double share = (row + 1.0) / look.rows;
      const std::vector<double> values =
          valuesOf(kRange.lo + span * entry / (look.entries - 1), span * share * share, kRange);
      for (size_t c = 0; c < 4; ++c) {
        const double expected = meanOf(values, [&](double v) {
          const auto at = rgba(v);
          return static_cast<double>(c < 3 ? at[c] * at[3] : at[3]);
        });
        const auto at = static_cast<size_t>(row * look.entries + entry);
        EXPECT_NEAR(look.rgba[4 * at + c], expected, tolerance) << row << ' ' << entry << ' ' << c;
      }
    }
}

TEST(ExpectedLook, aStepShowsTheShareThatItCovers) {
  const auto step = [](double v) {
    return v < 120 ? std::array{0.0F, 0.0F, 1.0F, 0.0F} : std::array{1.0F, 0.5F, 0.0F, 1.0F};
  };
  expectSums(lookUpOf(step), step, 0.01);
}

TEST(ExpectedLook, coloursAreWeightedByOpacity) {
  const auto bands = [](double v) {
    return v < 60    ? std::array{0.0F, 1.0F, 0.0F, 0.1F}
           : v < 180 ? std::array{1.0F, 0.0F, 0.0F, 0.7F}
                     : std::array{0.0F, 0.0F, 1.0F, 0.0F};
  };
  expectSums(lookUpOf(bands), bands, 0.01);
}

TEST(ExpectedLook, aRampHasTheOpacityOfTheMean) {
  const auto ramp = [](double v) {
    return std::array{1.0F, 1.0F, 1.0F, static_cast<float>((v - kRange.lo) / 300)};
  };
  const ExpectedLook look = expectedLook(lookUpOf(ramp), kRange);
  for (int row = 0; row < look.rows; ++row) {
    const double share = (row + 1.0) / look.rows;
    for (int entry = 0; entry < look.entries; ++entry) {
      const double mean = kRange.lo + (kRange.hi - kRange.lo) * entry / (look.entries - 1);
      const double kept = spreadValues(mean, (kRange.hi - kRange.lo) * share * share, kRange).mean;
      const auto at = static_cast<size_t>(row * look.entries + entry);
      ASSERT_NEAR(look.rgba[4 * at + 3], (kept - kRange.lo) / 300, 2e-4) << row << ' ' << entry;
    }
  }
}

}  // namespace
}  // namespace sluice
