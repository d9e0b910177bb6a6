// automaticLook on counts of the kinds of volumes that people have.
#include "src/classify/transfer/automatic_look.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/transfer_makers.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// Rounded draws of normal distributions, in no order: every neighbour differs.
class Draws {
 public:
  Draws& add(int count, double mean, double deviation) {
    std::normal_distribution<double> normal(mean, deviation);
    for (int i = 0; i < count; ++i) ++counts_[std::max(least_, std::round(normal(random_)))];
    return *this;
  }
  Draws& atLeast(double least) {
    least_ = least;
    return *this;
  }
  ValueCounts counts() const {
    ValueCounts result;
    for (const auto& [value, count] : counts_) result.entries.push_back({value, value, count});
    result.changes = total(result);
    result.jumps = 5 * result.changes;
    return result;
  }

 private:
  std::mt19937 random_{3};
  std::map<double, uint64_t> counts_;
  double least_ = -1e9;
};

TEST(AutomaticLook, oneBroadHumpIsASolidBlockInGrey) {
  const AutomaticLook look = automaticLook(Draws().add(100000, 140, 35).counts());
  EXPECT_THAT(look.transfer.name, HasSubstr("solid"));
  EXPECT_EQ(look.map, "grey");
  EXPECT_FALSE(look.lit);
  for (const double value : {40, 140, 250}) EXPECT_GT(opacityAt(look.transfer, value), 0.5);
}

TEST(AutomaticLook, fillValuesBesideASolidBlockShowNothing) {
  const AutomaticLook look =
      automaticLook(Draws().add(20000, 0, 0).atLeast(1).add(100000, 140, 30).counts());
  EXPECT_THAT(look.transfer.name, HasSubstr("solid"));
  EXPECT_EQ(opacityAt(look.transfer, 0), 0);
  EXPECT_GT(opacityAt(look.transfer, 140), 0.5);
}

TEST(AutomaticLook, objectAndAirAreNoSolidBlock) {
  for (const int object : {10000, 50000, 90000})
    EXPECT_THAT(
        automaticLook(Draws().add(40000, 10, 4).add(object, 150, 20).counts()).transfer.name,
        HasSubstr("above"));
}

TEST(AutomaticLook, vesselsFarAboveTissueShowAlone) {
  auto counts =
      Draws().atLeast(0).add(40000, 10, 6).add(60000, 150, 18).add(1200, 500, 120).counts();
  AutomaticLook look = automaticLook(counts);
  EXPECT_THAT(look.transfer.name, HasSubstr("tail"));
  EXPECT_EQ(opacityAt(look.transfer, 180), 0);
  EXPECT_GT(opacityAt(look.transfer, 500), 0.2);
  // The same without air, as after a subtraction.
  look = automaticLook(Draws().add(99000, 100, 20).add(1000, 600, 100).counts());
  EXPECT_THAT(look.transfer.name, HasSubstr("tail"));
  EXPECT_EQ(opacityAt(look.transfer, 160), 0);
}

// Like a head's MR: bright fluid next to tissue, and everything in between.
TEST(AutomaticLook, tissueThatFadesIntoBrighterTissueIsNoTail) {
  const auto counts = Draws()
                          .atLeast(0)
                          .add(70000, 1, 8)
                          .add(30000, 48, 19)
                          .add(9000, 70, 40)
                          .add(800, 160, 60)
                          .counts();
  const AutomaticLook look = automaticLook(counts);
  EXPECT_THAT(look.transfer.name, Not(HasSubstr("tail")));
  EXPECT_GT(opacityAt(look.transfer, 60), 0);
}

TEST(AutomaticLook, theBrightPartOfABroadHumpIsNoTail) {
  // A head in which fluid is bright and tissue reaches down to the air.
  const AutomaticLook head = automaticLook(
      Draws().atLeast(0).add(75000, 3, 4).add(40000, 50, 18).add(2500, 180, 40).counts());
  EXPECT_THAT(head.transfer.name, HasSubstr("above"));
  EXPECT_GT(opacityAt(head.transfer, 60), 0);
  // Smoke that is nowhere dense, in much nothing: from its thinnest on.
  Draws draws;
  draws.atLeast(0).add(950000, 0, 0);
  for (int i = 0; i < 50; ++i) draws.add(1000, 60 + 14 * i, 30);
  const AutomaticLook smoke = automaticLook(draws.counts());
  EXPECT_THAT(smoke.transfer.name, HasSubstr("above"));
  EXPECT_GT(opacityAt(smoke.transfer, 100), 0);
}

TEST(AutomaticLook, aSmallThingInMuchNothingHasItsWholeRange) {
  const AutomaticLook look = automaticLook(
      Draws().add(4000000, 0, 0).atLeast(1).add(900, 60, 8).add(900, 220, 8).counts());
  EXPECT_GT(opacityAt(look.transfer, 60), 0);
  EXPECT_GT(look.map_range.hi, 200);
}

TEST(AutomaticLook, valuesAllOverTheirRangeAreABlockInColours) {
  Draws even, wavy;
  for (int value = 0; value < 256; ++value) {
    even.add(100, value, 0);
    wavy.add(60 + static_cast<int>(40 * std::sin(value / 20.0)), value, 0);
  }
  for (const Draws& draws : {even, wavy}) {
    const AutomaticLook look = automaticLook(draws.counts());
    EXPECT_THAT(look.transfer.name, HasSubstr("solid"));
    EXPECT_EQ(look.map, "viridis");
    EXPECT_FALSE(look.lit);
    const ValueRange range = rangeOf(draws.counts());
    for (const double share : {0.02, 0.5, 0.98})
      EXPECT_GT(opacityAt(look.transfer, std::lerp(range.lo, range.hi, share)), 0.5);
  }
}

// --- CT

// A body in air with a fiftieth of bone, in Hounsfield units.
Draws body() {
  Draws draws;
  draws.atLeast(-1000).add(40000, -1000, 15).add(8000, -850, 60).add(36000, 30, 45);
  for (int i = 0; i < 20; ++i) draws.add(90, 300 + 140 * i, 60);
  return draws;
}

TEST(AutomaticLook, aCtInHounsfieldUnitsShowsItsBoneWhateverThePadding) {
  const AutomaticLook plain = automaticLook(body().counts());
  for (const double padding : {-1500, -2000, -3024, -32768}) {
    const AutomaticLook look = automaticLook(body().atLeast(-1e9).add(23000, padding, 0).counts());
    EXPECT_EQ(look.map, "ct-bone");
    EXPECT_THAT(look.transfer.name, HasSubstr("bone"));
    for (const double hidden : {padding, -1213.0, -1000.0, -700.0, 0.0, 100.0})
      EXPECT_EQ(opacityAt(look.transfer, hidden), 0) << hidden;
    EXPECT_GT(opacityAt(look.transfer, 1000), 0);
    EXPECT_EQ(look.map_range, plain.map_range) << "padding has no say";
  }
}

TEST(AutomaticLook, aCtWithoutBoneShowsItsSkin) {
  const AutomaticLook look = automaticLook(
      Draws().atLeast(-1024).add(40000, -1000, 15).add(36000, 30, 45).add(10, 260, 5).counts());
  EXPECT_THAT(look.transfer.name, HasSubstr("skin"));
  EXPECT_EQ(opacityAt(look.transfer, -900), 0);
  EXPECT_GT(opacityAt(look.transfer, 30), 0);
}

// Also one whose values end below those of bone, in any part of the picture.
TEST(AutomaticLook, aCtOfSoftTissueAloneShowsItsSkinWhateverThePadding) {
  for (const double padding : {0.0, -2000.0, -3024.0})
    for (const int body : {9000, 40000, 300000}) {
      SCOPED_TRACE(fmt::format("padding {} body {}", padding, body));
      Draws draws;
      draws.atLeast(-1e9).add(40000, -1000, 15).add(body, 40, 15).add(body / 4, -100, 15);
      draws.add(2000, -850, 15);
      if (padding < 0) draws.add(23000, padding, 0);
      const AutomaticLook look = automaticLook(draws.counts());
      EXPECT_THAT(look.transfer.name, HasSubstr("skin"));
      for (const double hidden : {-3024.0, -2000.0, -1500.0, -1000.0, -700.0})
        EXPECT_EQ(opacityAt(look.transfer, hidden), 0) << hidden;
      EXPECT_GT(opacityAt(look.transfer, 30), 0);
    }
}

TEST(AutomaticLook, aFieldOverTheValuesOfACtIsNone) {
  Draws field;
  for (int i = 0; i < 112; ++i) field.add(900, -1000 + 10 * i, 6);
  EXPECT_THAT(automaticLook(field.counts()).transfer.name, Not(HasSubstr("CT")));
}

TEST(AutomaticLook, whatIsNoCtHasNoColoursOfBone) {
  for (const double offset : {0.0, 1024.0, -500.0}) {
    const AutomaticLook look =
        automaticLook(Draws().add(40000, offset, 4).add(9000, offset + 140, 20).counts());
    EXPECT_EQ(look.map, "plaster") << offset;
  }
}

TEST(AutomaticLook, anObjectMayFillHalfABrightField) {
  const AutomaticLook look = automaticLook(Draws().add(50000, 240, 3).add(45000, 150, 20).counts());
  EXPECT_THAT(look.transfer.name, HasSubstr("below"));
  EXPECT_EQ(opacityAt(look.transfer, 240), 0);
  EXPECT_GT(opacityAt(look.transfer, 150), 0);
}

TEST(AutomaticLook, whereABlockEndsAtFillValuesItsDarkRimIsThin) {
  const AutomaticLook look =
      automaticLook(Draws().add(20000, 0, 0).atLeast(1).add(100000, 140, 30).counts());
  EXPECT_LT(opacityAt(look.transfer, 70), 0.2);
  EXPECT_GT(opacityAt(look.transfer, 140), 0.8);
}

TEST(AutomaticLook, boneAboveTissueIsNoTail) {
  const auto counts =
      Draws().add(60000, -1000, 15).add(50000, 40, 30).add(6000, 1200, 250).counts();
  EXPECT_THAT(automaticLook(counts).transfer.name, HasSubstr("above"));
}

TEST(AutomaticLook, paddingFarOffHasNoSay) {
  const auto ct = [](double padding, int count) {
    return Draws()
        .add(count, padding, 0)
        .add(40000, -1000, 15)
        .add(30000, 40, 30)
        .add(4000, 1200, 200)
        .counts();
  };
  const AutomaticLook plain = automaticLook(ct(-1000, 1));
  for (const double padding : {-2000.0, -32768.0, -1e6, 1e5}) {
    const AutomaticLook look = automaticLook(ct(padding, 20000));
    EXPECT_EQ(opacityAt(look.transfer, padding), 0) << padding;
    EXPECT_EQ(opacityAt(look.transfer, -1000), 0) << padding;
    EXPECT_GT(opacityAt(look.transfer, 1200), 0) << padding;
    EXPECT_NEAR(look.map_range.lo, plain.map_range.lo, 250) << padding;
    EXPECT_NEAR(look.map_range.hi, plain.map_range.hi, 250) << padding;
  }
}

TEST(AutomaticLook, twoValuesAreASurfaceBetweenThem) {
  for (const auto& [lo, hi] : {std::pair{0.0, 1.0}, {0.0, 255.0}, {-3.0, 8.0}, {1.0, 2.0}}) {
    const AutomaticLook look = automaticLook({{{lo, lo, 900}, {hi, hi, 100}}});
    EXPECT_EQ(opacityAt(look.transfer, lo), 0);
    EXPECT_EQ(opacityAt(look.transfer, hi), 1);
    EXPECT_GT(opacityAt(look.transfer, lo + 0.55 * (hi - lo)), 0.3);
    EXPECT_TRUE(look.lit);
  }
}

ValueCounts labelCounts() {
  // 2000 voxels in 200 things, whose ends differ by 10 on the mean.
  return {{{0, 0, 9000}, {2, 2, 500}, {5, 5, 700}, {17, 17, 300}, {40, 40, 500}}, 400, 4000};
}

TEST(AutomaticLook, labelsAreOpaqueInColoursOfTheirOwn) {
  const AutomaticLook look = automaticLook(labelCounts());
  EXPECT_TRUE(look.transfer.labels);
  EXPECT_EQ(opacityAt(look.transfer, 0), 0);
  std::vector<Vec3d> colors;
  for (const double value : {2, 5, 17, 40}) {
    EXPECT_EQ(opacityAt(look.transfer, value), 1);
    colors.push_back(colorAt(look.transfer, value));
    EXPECT_EQ(colors.back(), labelColor(value));
  }
  for (size_t i = 0; i < colors.size(); ++i)
    for (size_t k = 0; k < i; ++k) EXPECT_GT(length(colors[i] - colors[k]), 0.2);
  // A map that is asked for is laid over them.
  const AutomaticLook mapped = automaticLook(labelCounts(), {.map = "viridis"});
  EXPECT_TRUE(mapped.transfer.labels);
  EXPECT_EQ(colorAt(mapped.transfer, 40), colorMap("viridis")->back().rgb);
}

TEST(AutomaticLook, whatIsSmoothOrNoisyOrFractionalIsNoLabel) {
  ValueCounts counts = labelCounts();
  counts.jumps = counts.changes;  // by one value each
  EXPECT_FALSE(areLabels(counts));
  counts = labelCounts();
  counts.changes = 2500;  // nearly every voxel
  counts.jumps = 25000;
  EXPECT_FALSE(areLabels(counts));
  counts = labelCounts();
  counts.entries[1].lo = counts.entries[1].hi = 2.5;
  EXPECT_FALSE(areLabels(counts));
  counts = labelCounts();
  counts.entries[4].hi = 44;  // an interval
  EXPECT_FALSE(areLabels(counts));
}

TEST(AutomaticLook, twoMediaThatMixAreNoLabels) {
  // Half the voxels in each, and between them values that no neighbours share.
  ValueCounts gases{{{0, 0, 430000}, {200, 200, 430000}}, 92000, 690000};
  for (int value = 1; value < 200; ++value) {
    const auto at = static_cast<double>(value);
    gases.entries.insert(gases.entries.end() - 1, {at, at, 480});
  }
  EXPECT_FALSE(areLabels(gases));
  // Cells in two tissues are.
  ValueCounts cells = gases;
  cells.changes = 40000;
  EXPECT_TRUE(areLabels(cells));
}

TEST(AutomaticLook, labelsWithoutZeroLeaveOutTheMostFrequent) {
  EXPECT_EQ(backgroundLabel({{{1, 1, 10}, {2, 2, 500}, {3, 3, 20}}}), 2);
  EXPECT_EQ(backgroundLabel({{{-1, -1, 10}, {0, 0, 1}, {3, 3, 20}}}), 0);
  const TransferFunction transfer =
      labelsTransfer(labelStylesOf({{{1, 1, 10}, {2, 2, 500}, {3, 3, 20}}}));
  EXPECT_EQ(opacityAt(transfer, 1), 1);
  EXPECT_EQ(opacityAt(transfer, 2), 0);
  EXPECT_EQ(opacityAt(transfer, 3), 1);
}

TEST(AutomaticLook, isMadeOfWhatItSaysItIs) {
  for (const ValueCounts& counts :
       {Draws().add(70000, 10, 4).add(20000, 90, 8).counts(),
        Draws().add(80000, 250, 2).add(15000, 120, 10).counts(),
        Draws().add(60000, 0, 1).add(3000, 12, 3).add(3000, -12, 3).counts(),
        Draws().add(100000, 140, 35).counts(),
        ValueCounts{{{0.1, 0.2, 50}, {0.3, 0.3, 70}, {0.9, 1.1, 20}}}, ValueCounts{{{7, 7, 50}}}}) {
    const AutomaticLook look = automaticLook(counts);
    const TransferFunction again =
        pointsTransfer(look.map, look.map_range, look.transfer.opacities);
    ASSERT_EQ(again.colors.size(), look.transfer.colors.size());
    for (size_t i = 0; i < again.colors.size(); ++i) {
      EXPECT_EQ(again.colors[i].value, look.transfer.colors[i].value);
      EXPECT_EQ(again.colors[i].rgb, look.transfer.colors[i].rgb);
    }
  }
}

}  // namespace
}  // namespace sluice
