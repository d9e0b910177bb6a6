#include "src/classify/transfer/transfer_function.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/segments.h"
#include "tests/support/gradient_factor.h"

namespace sluice {
namespace {

using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TransferFunction withOpacities(std::vector<OpacityPoint> points) {
  return {{{0, {1, 1, 1}}}, std::move(points), "test"};
}

// The contract computed in another way: a walk over all points.
double walkedOpacity(const std::vector<OpacityPoint>& points, double value) {
  if (value < points.front().value) return points.front().opacity;
  double result = points.back().opacity;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const OpacityPoint& a = points[i];
    const OpacityPoint& b = points[i + 1];
    if (a.value <= value && value < b.value) {
      result = a.opacity + (b.opacity - a.opacity) * (value - a.value) / (b.value - a.value);
    }
  }
  return result;
}

std::string messageOf(const TransferFunction& transfer) {
  try {
    validate(transfer, "here");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(TransferFunction, isLinearBetweenPointsAndConstantBeyond) {
  const auto transfer = withOpacities({{10, 0.2}, {20, 0.6}});
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 15), 0.4);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 12.5), 0.3);
  EXPECT_EQ(opacityAt(transfer, -1e300), 0.2);
  EXPECT_EQ(opacityAt(transfer, kInfinity), 0.6);
  EXPECT_EQ(opacityAt(transfer, -kInfinity), 0.2);
}

TEST(TransferFunction, interpolatesEachColorChannel) {
  const TransferFunction transfer{{{0, {0, 0.5, 1}}, {4, {1, 0.25, 1}}}, {{0, 1}}, ""};
  EXPECT_EQ(colorAt(transfer, 1), (Vec3d{0.25, 0.4375, 1}));
  EXPECT_EQ(colorAt(transfer, -1), (Vec3d{0, 0.5, 1}));
  EXPECT_EQ(colorAt(transfer, 9), (Vec3d{1, 0.25, 1}));
}

TEST(TransferFunction, stepsWhereTwoPointsShareAValue) {
  const auto transfer = withOpacities({{0, 0.1}, {40, 0.1}, {40, 0.7}, {80, 0.7}});
  EXPECT_EQ(opacityAt(transfer, std::nextafter(40.0, 0)), 0.1);
  EXPECT_EQ(opacityAt(transfer, 40), 0.7);
  EXPECT_EQ(opacityAt(transfer, std::nextafter(40.0, 80)), 0.7);
}

TEST(TransferFunction, stepsAtTheFirstAndAtTheLastPoint) {
  const auto transfer = withOpacities({{1, 0}, {1, 0.3}, {2, 0.4}, {2, 0.9}});
  EXPECT_EQ(opacityAt(transfer, 0.999), 0);
  EXPECT_EQ(opacityAt(transfer, 1), 0.3);
  EXPECT_NEAR(opacityAt(transfer, 1.999999), 0.4, 1e-6);
  EXPECT_EQ(opacityAt(transfer, 2), 0.9);
  EXPECT_EQ(opacityAt(transfer, 3), 0.9);
}

TEST(TransferFunction, lastOfSeveralPointsAtAValueHoldsFromThere) {
  const auto transfer = withOpacities({{5, 0.1}, {5, 0.9}, {5, 0.4}});
  EXPECT_EQ(opacityAt(transfer, 4), 0.1);
  EXPECT_EQ(opacityAt(transfer, 5), 0.4);
  EXPECT_EQ(opacityAt(transfer, 6), 0.4);
}

TEST(TransferFunction, notANumberIsInvisible) {
  const auto transfer = withOpacities({{0, 0.5}, {1, 1}});
  EXPECT_EQ(opacityAt(transfer, kNan), 0);
  EXPECT_EQ(colorAt(transfer, kNan), (Vec3d{1, 1, 1}));
}

TEST(TransferFunction, valuesWhoseDistanceOverflowsInterpolate) {
  const double most = std::numeric_limits<double>::max();
  const auto transfer = withOpacities({{-most, 0}, {most, 1}});
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 0), 0.5);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, most / 2), 0.75);
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_DOUBLE_EQ(opacityAt(withOpacities({{0, 0}, {2 * least, 1}}), least), 0.5);
}

TEST(TransferFunction, agreesWithAWalkOverAllPointsOnRandomOnes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 200; ++round) {
    std::vector<OpacityPoint> points(1 + random() % 12);
    // Few distinct values, so that there are steps.
    for (OpacityPoint& point : points) {
      point = {static_cast<double>(random() % 10) - 5, unit(random)};
    }
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
    const auto transfer = withOpacities(points);
    for (double value = -6; value <= 6; value += 0.125) {
      EXPECT_NEAR(opacityAt(transfer, value), walkedOpacity(points, value), 1e-14)
          << "round " << round << " value " << value;
    }
    for (size_t i = 0; i < points.size(); ++i) {
      if (i + 1 < points.size() && points[i + 1].value == points[i].value) continue;
      EXPECT_EQ(opacityAt(transfer, points[i].value), points[i].opacity);
    }
  }
}

TEST(TransferFunction, risesWhereItsPointsRise) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> values(8), heights(8);
    for (double& value : values) value = 1000 * unit(random);
    for (double& height : heights) height = unit(random);
    std::sort(values.begin(), values.end());
    std::sort(heights.begin(), heights.end());
    std::vector<OpacityPoint> points;
    for (size_t i = 0; i < values.size(); ++i) points.push_back({values[i], heights[i]});
    const auto transfer = withOpacities(points);
    double before = 0;
    for (double value = -1; value < 1001; value += 0.37) {
      const double opacity = opacityAt(transfer, value);
      EXPECT_GE(opacity, before);
      EXPECT_LE(opacity, heights.back());
      before = opacity;
    }
  }
}

TEST(TransferFunction, validatesWhatItsContractSays) {
  const TransferFunction good{{{0, {0, 0, 0}}, {1, {1, 1, 1}}}, {{0, 0}, {0, 1}}, ""};
  EXPECT_EQ(messageOf(good), "");
  auto bad = good;
  bad.colors.clear();
  EXPECT_EQ(messageOf(bad), "here: expected at least one point in colors, found none");
  bad = good;
  bad.opacities.clear();
  EXPECT_THAT(messageOf(bad), HasSubstr("opacities, found none"));
  bad = good;
  bad.colors[1].value = -1;
  EXPECT_EQ(messageOf(bad), "here: expected colors to ascend by value, found -1 after 0 at [1]");
  for (const double value : {kNan, kInfinity, -kInfinity}) {
    bad = good;
    bad.opacities[1].value = value;
    EXPECT_THAT(messageOf(bad), HasSubstr("expected a finite value in opacities[1]"));
  }
  for (const double share : {-0.001, 1.001, kNan, kInfinity}) {
    bad = good;
    bad.opacities[0].opacity = share;
    EXPECT_THAT(messageOf(bad), HasSubstr("expected an opacity in 0..1 in opacities[0]"));
    for (int channel = 0; channel < 3; ++channel) {
      bad = good;
      bad.colors[1].rgb[channel] = share;
      EXPECT_THAT(messageOf(bad), HasSubstr("in 0..1 in colors[1]"));
    }
  }
}

TEST(GradientFactor, isBilinearBetweenRowsAndTheirPoints) {
  TransferFunction transfer{{{0, {1, 1, 1}}}, {{0, 1}}, "rows"};
  EXPECT_EQ(gradientFactorAt(transfer, 3, 7), 1) << "without rows";
  transfer.gradients = {{2, {{0, 0}, {10, 1}}}, {6, {{0, 0.5}}}};
  EXPECT_EQ(gradientFactorAt(transfer, 5, 0), 0.5) << "below the first row";
  EXPECT_EQ(gradientFactorAt(transfer, 5, 2), 0.5);
  EXPECT_DOUBLE_EQ(gradientFactorAt(transfer, 10, 3), 0.75 * 1 + 0.25 * 0.5);
  EXPECT_DOUBLE_EQ(gradientFactorAt(transfer, 0, 4), 0.25);
  EXPECT_EQ(gradientFactorAt(transfer, 0, 100), 0.5) << "beyond the last row";
  EXPECT_EQ(gradientFactorAt(transfer, std::numeric_limits<double>::quiet_NaN(), 4), 0);
}

TEST(GradientFactor, rowsAreValidated) {
  const TransferFunction good{{{0, {1, 1, 1}}}, {{0, 1}}, "rows", {{0, {{0, 0}}}, {2, {{0, 1}}}}};
  validate(good, "good");
  const auto expectRejected = [&](const std::vector<GradientRow>& rows, const char* what) {
    TransferFunction bad = good;
    bad.gradients = rows;
    EXPECT_THROW(validate(bad, "bad"), Error) << what;
  };
  expectRejected({{-1, {{0, 0}}}}, "below 0");
  expectRejected({{2, {{0, 0}}}, {2, {{0, 1}}}}, "a step");
  expectRejected({{3, {{0, 0}}}, {2, {{0, 1}}}}, "descending");
  expectRejected({{0, {}}}, "no factor");
  expectRejected({{0, {{0, 1.5}}}}, "a factor above 1");
  expectRejected({{0, {{4, 1}, {3, 1}}}}, "descending values");
  expectRejected({{std::numeric_limits<double>::infinity(), {{0, 1}}}}, "infinite");
  std::vector<GradientRow> many;
  for (size_t i = 0; i <= kMostGradientRows; ++i)
    many.push_back({static_cast<double>(i), {{0, 1}}});
  expectRejected(many, "too many");
  many.pop_back();
  TransferFunction most = good;
  most.gradients = many;
  validate(most, "most");
}

TEST(TransferFunction, runsAreTheSegmentsThatASearchFinds) {
  // Steps, a far end, and values at, between and beyond the points, up and down.
  const std::vector<OpacityPoint> points{{-2, 0.1}, {1, 0.3},   {1, 0.7},      {1, 0.2},
                                         {5, 1},    {1e300, 0}, {1.7e308, 0.5}};
  std::vector<double> values{-1e300, -2, -1, 1, 1.5, 5, 6, 1e300, 1.5e300, 1.7e308};
  for (const bool descends : {false, true}) {
    if (descends) std::ranges::reverse(values);
    std::vector<double> ways(values.size());
    size_t next = 0;
    eachRun(points, values, [&](const SegmentRun<OpacityPoint>& run) {
      EXPECT_EQ(run.first, next);
      waysOf(run, values, ways);
      for (next = run.first; next < run.end; ++next) {
        const Segment<OpacityPoint> expected = segmentAt(points, values[next]);
        EXPECT_EQ(&run.a, &expected.a) << values[next];
        EXPECT_EQ(&run.b, &expected.b) << values[next];
        EXPECT_EQ(ways[next], expected.t) << values[next];
      }
    });
    EXPECT_EQ(next, values.size());
  }
}

TEST(TransferFunction, aRunIsInterpolatedToTheLastBit) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> part(-1, 1), way(0, 1);
  for (int i = 0; i < 200; ++i) {
    const double a = i % 5 == 0 ? 0 : part(random), b = i % 7 == 0 ? a : part(random);
    std::vector<double> ways{0, 1, std::nextafter(1, 0)};
    while (ways.size() < 40) ways.push_back(way(random));
    std::vector<double> out(ways.size());
    lerpRun(a, b, ways, out);
    for (size_t k = 0; k < ways.size(); ++k)
      ASSERT_EQ(out[k], std::lerp(a, b, ways[k])) << a << ' ' << b << ' ' << ways[k];
  }
}

}  // namespace
}  // namespace sluice
