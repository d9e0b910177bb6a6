#include "src/view/state/editing/look_edit.h"

#include <gtest/gtest.h>

#include "src/base/looks/color_word.h"

namespace sluice {
namespace {

TEST(LookEdit, keepsOneLookAChannel) {
  LookOptions look;
  channelOf(look, "1").opacity = 0.5;
  channelOf(look, "0").map = "green";
  channelOf(look, "1").map = "red";
  ASSERT_EQ(look.channels.size(), 2U);
  EXPECT_EQ(look.channels[0], (LookOptions::Channel{.channel = "1", .map = "red", .opacity = 0.5}));
  EXPECT_EQ(look.channels[1], (LookOptions::Channel{.channel = "0", .map = "green"}));
}

TEST(LookEdit, writesColorsAsOptionsHaveThem) {
  EXPECT_EQ(colorWord(Rgb{1, 0.5333, 0}), "ff8800");
  EXPECT_EQ(colorWord(Rgb{-1, 2, 1.0 / 255}), "00ff01");
}

TEST(LookEdit, hasTheColorsOfTheMap) {
  ShownLook look;
  EXPECT_EQ(colorAt(look, 3), (Rgb{1, 1, 1}));
  look.colors = {{10, {0, 0, 0}}, {20, {1, 0.5, 0}}};
  EXPECT_EQ(colorAt(look, 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(colorAt(look, 15), (Rgb{0.5, 0.25, 0}));
  EXPECT_EQ(colorAt(look, 99), (Rgb{1, 0.5, 0}));
}

TEST(LookEdit, namesLabels) {
  ShownLook look;
  EXPECT_EQ(valueText(look, 12.34567), "12.346");
  look.label_names = {{3, "liver"}, {12, "heart"}};
  EXPECT_EQ(valueText(look, 12), "12 (heart)");
  EXPECT_EQ(valueText(look, 4), "4");
  EXPECT_EQ(valueText(look, 99), "99");
}

TEST(LookEdit, addsSurfacesApart) {
  LookOptions look = {.threshold = 250};
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(takesSurface(look, {}));
    look = withSurface(look, {0, 255});
  }
  EXPECT_FALSE(takesSurface(look, {}));
  EXPECT_EQ(look.surfaces.front().value, 250);
  for (size_t i = 0; i < look.surfaces.size(); ++i) {
    EXPECT_GE(look.surfaces[i].value, 0);
    EXPECT_LE(look.surfaces[i].value, 255);
    for (size_t k = 0; k < i; ++k)
      EXPECT_NE(look.surfaces[i].value, look.surfaces[k].value) << i << " " << k;
  }
  EXPECT_EQ(withSurface({}, {7, 7}).surfaces.front().value, 7);
}

TEST(LookEdit, writesReadingsWithoutMinusZeros) {
  EXPECT_EQ(readingText({}, {{73.2, -0.3, 42.6}, {-0.0, 1.5, -3}, -0.0}, "mm"),
            "0 at 0, 1.5, -3 mm (voxel 73, 0, 43)");
  ShownLook labels;
  labels.label_names = {{3, "liver"}};
  EXPECT_EQ(readingText(labels, {{1, 2, 3}, {4, 5, 6}, 3}, ""),
            "3 (liver) at 4, 5, 6 (voxel 1, 2, 3)");
}

TEST(LookEdit, addsNoSurfaceWhereNoneIsDrawn) {
  EXPECT_FALSE(takesSurface({.mode = LookOptions::Mode::kMaximum}, {}));
  ShownLook labels, channels;
  labels.labels = true;
  channels.channels.resize(2);
  EXPECT_FALSE(takesSurface({}, labels));
  EXPECT_FALSE(takesSurface({}, channels));
  channels.channels[1].channel = "over";
  EXPECT_TRUE(takesSurface({}, channels));
  EXPECT_FALSE(takesSurface({.combine = LookOptions::Combine::kBlend}, channels));
}

TEST(LookEdit, knowsWhetherChannelsAreOneMedium) {
  ShownLook shown;
  shown.blends = true;
  PictureOptions picture;
  EXPECT_TRUE(blendsChannels({}, picture, shown));
  EXPECT_FALSE(blendsChannels({.combine = LookOptions::Combine::kAdd}, picture, shown));
  EXPECT_TRUE(blendsChannels({.combine = LookOptions::Combine::kBlend}, picture, {}));
  picture.lighting.shadows = 0.5;
  EXPECT_FALSE(blendsChannels({}, picture, shown));
}

}  // namespace
}  // namespace sluice
