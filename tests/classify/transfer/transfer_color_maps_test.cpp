#include "src/classify/transfer/color_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <string_view>

#include "src/base/error.h"
#include "src/classify/transfer/color_spaces.h"

namespace sluice {
namespace {

using testing::HasSubstr;

Vec3d mapColor(std::string_view name, double t) {
  const auto points = colorMap(name);
  if (!points) throw Error("no map of this name");
  return colorAt({*points, {{0, 1}}, ""}, t);
}

double largestDifference(Vec3d a, Vec3d b) {
  const Vec3d d = a - b;
  return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
}

double lightness(Vec3d rgb) {
  return labFromRgb(rgb).x;
}

struct Published {
  std::string_view name;
  // Entries 0, 36, 73, 109, 146, 182, 219 and 255 of the 256-entry table.
  Vec3d entries[8];
};

const Published kPublished[] = {
    {"viridis",
     {{68, 1, 84},
      {70, 50, 126},
      {54, 92, 141},
      {39, 127, 142},
      {31, 161, 135},
      {74, 193, 109},
      {160, 218, 57},
      {253, 231, 37}}},
    {"inferno",
     {{0, 0, 4},
      {40, 11, 83},
      {101, 21, 110},
      {159, 42, 99},
      {212, 72, 66},
      {245, 125, 21},
      {250, 194, 40},
      {252, 255, 164}}},
    {"plasma",
     {{13, 8, 135},
      {83, 2, 163},
      {139, 10, 165},
      {184, 50, 137},
      {219, 92, 104},
      {244, 136, 73},
      {254, 189, 42},
      {240, 249, 33}}},
    {"magma",
     {{0, 0, 4},
      {34, 17, 80},
      {95, 24, 127},
      {152, 45, 128},
      {211, 67, 110},
      {248, 118, 92},
      {254, 187, 129},
      {252, 253, 191}}},
    {"cividis",
     {{0, 34, 78},
      {33, 59, 110},
      {76, 85, 108},
      {108, 110, 114},
      {142, 137, 120},
      {177, 165, 112},
      {217, 197, 92},
      {254, 232, 56}}},
    {"turbo",
     {{48, 18, 59},
      {71, 118, 238},
      {27, 208, 213},
      {97, 252, 108},
      {210, 233, 53},
      {254, 155, 45},
      {218, 57, 7},
      {122, 4, 3}}},
    {"cool-warm",
     {{59, 76, 192},
      {103, 136, 238},
      {154, 187, 255},
      {201, 216, 240},
      {238, 209, 194},
      {247, 168, 137},
      {226, 105, 82},
      {180, 4, 38}}},
    {"black-body",
     {{0, 0, 0},
      {65, 22, 17},
      {128, 31, 27},
      {187, 50, 32},
      {224, 101, 9},
      {235, 160, 10},
      {242, 215, 63},
      {255, 255, 255}}},
};

TEST(ColorMaps, stayWithinTwoLevelsOfThePublishedTables) {
  constexpr std::array<int, 8> kEntries = {0, 36, 73, 109, 146, 182, 219, 255};
  for (const Published& map : kPublished) {
    for (size_t i = 0; i < kEntries.size(); ++i) {
      // Half a level more: the table's entries are rounded to whole ones.
      EXPECT_LE(largestDifference(mapColor(map.name, kEntries[i] / 255.0) * 255, map.entries[i]),
                2.5)
          << map.name << " entry " << kEntries[i];
    }
  }
}

TEST(ColorMaps, areValidAndSpanZeroToOne) {
  std::set<std::string_view> names;
  for (const std::string_view name : colorMapNames()) {
    EXPECT_TRUE(names.insert(name).second) << name << " is listed twice";
    const auto points = colorMap(name);
    ASSERT_TRUE(points) << name;
    EXPECT_EQ(points->front().value, 0) << name;
    EXPECT_EQ(points->back().value, 1) << name;
    EXPECT_NO_THROW(validate({*points, {{0, 1}}, ""}, std::string(name)));
  }
  for (const std::string_view wanted :
       {"viridis", "inferno", "plasma", "magma", "cividis", "turbo", "cool-warm", "black-body",
        "hot", "grey", "ct-bone", "ct-soft-tissue", "smoke", "ember", "plaster"}) {
    EXPECT_TRUE(names.contains(wanted)) << wanted;
  }
  EXPECT_TRUE(names.contains(kDefaultColorMap));
}

// A map is good for volumes if darker always means less.
TEST(ColorMaps, sequentialOnesGrowLighter) {
  for (const std::string_view name : colorMapNames()) {
    if (name == "turbo" || name == "cool-warm") continue;
    double before = -1;
    for (int i = 0; i <= 500; ++i) {
      const double now = lightness(mapColor(name, i / 500.0));
      EXPECT_GT(now, before - 1e-9) << name << " at " << i / 500.0;
      before = now;
    }
  }
}

TEST(ColorMaps, coolWarmIsLightestInTheMiddleAndCoolFirst) {
  EXPECT_GT(lightness(mapColor("cool-warm", 0.5)), lightness(mapColor("cool-warm", 0)) + 40);
  EXPECT_GT(lightness(mapColor("cool-warm", 0.5)), lightness(mapColor("cool-warm", 1)) + 40);
  EXPECT_GT(mapColor("cool-warm", 0.1).z, mapColor("cool-warm", 0.1).x);
  EXPECT_GT(mapColor("cool-warm", 0.9).x, mapColor("cool-warm", 0.9).z);
}

TEST(ColorMaps, aColourIsAMapOfItsOwn) {
  for (const std::string_view name : solidColorNames()) {
    const auto points = colorMap(name);
    ASSERT_TRUE(points) << name;
    EXPECT_EQ(points->front().rgb, points->back().rgb);
    EXPECT_EQ(points->front().value, 0);
    EXPECT_EQ(points->back().value, 1);
  }
  EXPECT_EQ(colorMap("green")->front().rgb, (Vec3d{0, 1, 0}));
  for (const std::string_view orange : {"#ff8000", "ff8000", "#FF8000"}) {
    const auto points = colorMap(orange);
    ASSERT_TRUE(points) << orange;
    EXPECT_EQ(points->front().rgb, (Vec3d{255, 128, 0} / 255.0));
  }
  for (const std::string_view wrong :
       {"#ff880", "#ff88001", "#gg8800", "gren", "#", "0xff88", "+f8800"})
    EXPECT_FALSE(colorMap(wrong)) << wrong;
}

TEST(ColorMaps, unknownNameIsAnErrorThatListsTheNames) {
  EXPECT_FALSE(colorMap("virids"));
  EXPECT_FALSE(colorMap(""));
  try {
    requireColorMap("virids", "--map");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("--map: expected one of "));
    EXPECT_THAT(error.what(), HasSubstr("found 'virids'"));
    for (const std::string_view name : colorMapNames()) {
      EXPECT_THAT(error.what(), HasSubstr(std::string(name)));
    }
  }
}

TEST(ColorMaps, rescaleMeetsBothEndsExactly) {
  for (const ValueRange range : {ValueRange{-1024, 3071}, ValueRange{0.1, 0.3},
                                 ValueRange{-1e308, 1e308}, ValueRange{7, 7}}) {
    const auto points = rescale(*colorMap("viridis"), range.lo, range.hi);
    EXPECT_EQ(points.front().value, range.lo);
    EXPECT_EQ(points.back().value, range.hi);
    EXPECT_NO_THROW(validate({points, {{0, 1}}, ""}, "rescaled"));
  }
  EXPECT_EQ(colorAt({rescale(*colorMap("grey"), 10, 20), {{0, 1}}, ""}, 15), (Vec3d{.5, .5, .5}));
}

}  // namespace
}  // namespace sluice
