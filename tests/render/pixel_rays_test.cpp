// Which of several rays a pixel shows.
#include "src/render/frame/pixel_rays.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  EXPECT_EQ(keptRay(hill, Mode::kComposite), KeptRay::kBrightest);
}

TEST(KeptRay, replacesPixelsThatAreLessOpaqueFirst) {
  const auto pixels = [](const std::vector<float>& rgba) {
    Picture picture;
    picture.width = static_cast<int>(rgba.size() / 4);
    picture.height = 1;
    picture.rgba = {rgba.begin(), rgba.end()};
    return picture;
  };
  const Picture more = pixels({0.1F, 0.1F, 0.1F, 1, 0.7F, 0, 0, 1});
  const Picture first = pixels({0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0, 0, 1});
  Picture kept = first;
  keepMost(kept, more, KeptRay::kBrightest);
  EXPECT_EQ(kept.rgba, more.rgba);
  kept = first;
  keepMost(kept, more, KeptRay::kDarkest);
  EXPECT_EQ(kept.rgba, pixels({0.1F, 0.1F, 0.1F, 1, 0.5F, 0, 0, 1}).rgba);
}

}  // namespace
}  // namespace sluice
