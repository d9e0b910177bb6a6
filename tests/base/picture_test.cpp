#include "src/base/values/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sluice::picture_test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

// An opaque picture of one row with these reds.
Picture reds(const std::vector<float>& values) {
  Picture picture{static_cast<int>(values.size()), 1, {}, {}};
  for (const float red : values) picture.rgba.insert(picture.rgba.end(), {red, 0, 0, 1});
  return picture;
}

// More pixels than are converted at a time.
Picture noise() {
  Picture picture{61, 53, std::vector<float>(size_t{61} * 53 * 4), {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-0.2F, 1.2F);
  for (float& channel : picture.rgba) channel = value(random);
  return picture;
}

TEST(Picture, roundsToTheNearestByte) {
  std::vector<float> values{0, 1, -1, 2, kInfinity, -kInfinity, kNotANumber};
  for (int byte = 0; byte < 255; ++byte) {
    const float half = (static_cast<float>(byte) + 0.5F) / 255;
    values.insert(values.end(), {half, std::nextafter(half, 0.0F), std::nextafter(half, 1.0F),
                                 static_cast<float>(byte) / 255});
  }
  const Rgba8Picture bytes = toRgba8(reds(values));
  for (size_t i = 0; i < values.size(); ++i) {
    const float value = values[i];
    const long expected = !(value > 0) ? 0 : value >= 1 ? 255 : std::lround(value * 255);
    EXPECT_EQ(bytes.rgba[4 * i], expected) << value;
  }
}

TEST(Picture, bytesOverABackgroundAreThoseOfThePictureOverIt) {
  const std::array<float, 3> background{0.2F, 0.5F, 0.9F};
  const Picture picture = noise();
  const Rgba8Picture expected = toRgba8(over(picture, background));
  EXPECT_EQ(rgba8Over(picture.rgba, background), expected.rgba);
}

TEST(Picture, bytesWithoutABackgroundKeepStraightAlpha) {
  EXPECT_EQ(rgba8(std::vector<float>{0.1F, 0.2F, 0, 0.4F, 0.5F, 0.5F, 0.5F, 0}),
            (std::vector<uint8_t>{64, 128, 0, 102, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace sluice::picture_test
