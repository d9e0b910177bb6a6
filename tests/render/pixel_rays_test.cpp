// Which of several rays a pixel shows.
#include "src/render/frame/pixel_rays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sluice {
namespace {

// Grey entries of these levels, all of which show but those of a negative level.
LookUp greys(const std::vector<float>& levels) {
  LookUp look_up;
  for (const float level : levels) {
    const float shown = std::max(level, 0.0F);
    look_up.rgba.insert(look_up.rgba.end(), {shown, shown, shown, level < 0 ? 0.0F : 1.0F});
  }
  return look_up;
}

TEST(KeptRay, isTheOneWhoseValueWins) {
  const LookUp rising = greys({-1, 0, 0.5F, 0.5F, 1}), falling = greys({1, 0.5F, 0, -1});
  EXPECT_EQ(keptRay(rising, Mode::kMip), KeptRay::kBrightest);
  EXPECT_EQ(keptRay(rising, Mode::kMinip), KeptRay::kDarkest);
  EXPECT_EQ(keptRay(falling, Mode::kMip), KeptRay::kDarkest);
  EXPECT_EQ(keptRay(falling, Mode::kMinip), KeptRay::kBrightest);
}

TEST(KeptRay, isUnknownIfColoursDoNotTellIt) {
  const LookUp hill = greys({0, 1, 0.5F});
  EXPECT_EQ(keptRay(hill, Mode::kMip), std::nullopt);
  EXPECT_EQ(keptRay(hill, Mode::kMinip), std::nullopt);
  EXPECT_EQ(keptRay(greys({0, 1}), Mode::kAverage), std::nullopt);
  EXPECT_EQ(keptRay(hill, Mode::kComposite), KeptRay::kEachChannel);
  LookUp labels = hill;
  labels.labels = true;
  EXPECT_EQ(keptRay(labels, Mode::kComposite), KeptRay::kBrightest);
}

Picture pixels(const std::vector<float>& rgba) {
  Picture picture;
  picture.width = static_cast<int>(rgba.size() / 4);
  picture.height = 1;
  picture.rgba = rgba;
  return picture;
}

TEST(KeptRay, replacesPixelsThatAreLessOpaqueFirst) {
  const Picture more = pixels({0.1F, 0.1F, 0.1F, 1, 0.7F, 0, 0, 1});
  const Picture first = pixels({0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0, 0, 1});
  Picture kept = first;
  keepMost(kept, more, KeptRay::kBrightest);
  EXPECT_EQ(kept.rgba, more.rgba);
  kept = first;
  keepMost(kept, more, KeptRay::kDarkest);
  EXPECT_EQ(kept.rgba, pixels({0.1F, 0.1F, 0.1F, 1, 0.5F, 0, 0, 1}).rgba);
}

// A ray that shows nothing loses, also against white of which little shows.
TEST(KeptRay, showsSomethingRatherThanNothing) {
  for (const KeptRay ray : {KeptRay::kEachChannel, KeptRay::kBrightest, KeptRay::kDarkest}) {
    const Picture nothing = pixels({0, 0, 0, 0}), white = pixels({0.01F, 0.01F, 0.01F, 0.01F});
    Picture kept = nothing;
    keepMost(kept, white, ray);
    EXPECT_EQ(kept.rgba, white.rgba);
    keepMost(kept, nothing, ray);
    EXPECT_EQ(kept.rgba, white.rgba);
  }
}

TEST(KeptRay, isTheSameIfAnOpaqueOneIsRounded) {
  const float rounded = std::nextafter(1.0F, 0.0F);
  for (const KeptRay ray : {KeptRay::kEachChannel, KeptRay::kBrightest, KeptRay::kDarkest})
    for (const float first : {1.0F, rounded})
      for (const float second : {1.0F, rounded}) {
        Picture kept = pixels({0.2F, 0.1F, 0.1F, first});
        keepMost(kept, pixels({0.9F, 0.7F, 0.5F, second}), ray);
        EXPECT_EQ(kept.rgba[0], ray == KeptRay::kDarkest ? 0.2F : 0.9F) << first << second;
      }
}

TEST(KeptRay, ofEachChannelIsTheGreatestAndNearest) {
  Picture kept = pixels({0.2F, 0.6F, 0.1F, 0.7F}), more = pixels({0.5F, 0.3F, 0.1F, 0.6F});
  kept.depth = {8};
  more.depth = {5};
  keepMost(kept, more, KeptRay::kEachChannel);
  EXPECT_EQ(kept.rgba, pixels({0.5F, 0.6F, 0.1F, 0.7F}).rgba);
  EXPECT_EQ(kept.depth, std::vector<float>{5});
}

}  // namespace
}  // namespace sluice
