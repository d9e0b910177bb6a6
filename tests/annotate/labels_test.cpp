// Numbers and units as people write them.
#include "src/annotate/labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sluice {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;

TEST(Labels, roundLengthsAreOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(roundBelow(1), 1);
  EXPECT_DOUBLE_EQ(roundBelow(1.99), 1);
  EXPECT_DOUBLE_EQ(roundBelow(4.9), 2);
  EXPECT_DOUBLE_EQ(roundBelow(730), 500);
  EXPECT_DOUBLE_EQ(roundBelow(0.003), 0.002);
  EXPECT_DOUBLE_EQ(roundBelow(1e-9), 1e-9) << "powers of ten that are not exact";
  EXPECT_DOUBLE_EQ(roundBelow(1e15), 1e15);
}

TEST(Labels, ticksAreRoundAndInside) {
  EXPECT_THAT(ticks({0, 255}, 6), ElementsAre(0, 50, 100, 150, 200, 250));
  EXPECT_THAT(ticks({-1, 1}, 5), ElementsAre(-1, -0.5, 0, 0.5, 1));
  EXPECT_THAT(ticks({40, 41}, 3), ElementsAre(40, 40.5, 41));
  EXPECT_THAT(ticks({7, 7}, 5), ElementsAre(7));
  for (const double span : {1e-6, 0.3, 17.0, 999.0, 4.2e8})
    for (const int count : {2, 4, 7}) {
      const std::vector<double> values = ticks({3, 3 + span}, count);
      EXPECT_GE(values.size(), 1U);
      EXPECT_LE(values.size(), static_cast<size_t>(count) + 2) << span << " " << count;
      for (const double value : values) {
        EXPECT_GE(value, 3 - 1e-6 * span);
        EXPECT_LE(value, 3 + span * (1 + 1e-6));
      }
    }
}

TEST(Labels, numbersAreAsLongAsTheirStepNeeds) {
  EXPECT_EQ(tickLabel(50, 50), "50");
  EXPECT_EQ(tickLabel(0.25, 0.05), "0.25");
  EXPECT_EQ(tickLabel(40, 0.5), "40.0");
  EXPECT_EQ(tickLabel(1e-17, 0.5), "0");
  EXPECT_EQ(tickLabel(-20000, 10000), "-20000");
  EXPECT_EQ(tickLabel(3e8, 1e8), "3e+08");
  EXPECT_EQ(tickLabel(2e-7, 1e-7), "2e-07");
}

TEST(Labels, unitsAreSymbols) {
  EXPECT_EQ(unitSymbol("millimeter"), "mm");
  EXPECT_EQ(unitSymbol("micrometers"), "µm");
  EXPECT_EQ(unitSymbol("um"), "µm");
  EXPECT_EQ(unitSymbol("parsec"), "parsec");
  EXPECT_EQ(unitSymbol(""), "units");
}

}  // namespace
}  // namespace sluice
