#include "src/view/state/screen/scaled_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace sluice {
namespace {

std::vector<uint8_t> noise(int width, int height) {
  std::mt19937 random(5);
  std::vector<uint8_t> rgba(static_cast<size_t>(width) * static_cast<size_t>(height) * 4);
  for (uint8_t& byte : rgba) byte = static_cast<uint8_t>(random());
  return rgba;
}

int channelOf(uint32_t bgra, int channel) {
  constexpr std::array kShift{16, 8, 0, 24};
  return static_cast<int>(bgra >> static_cast<unsigned>(kShift[static_cast<size_t>(channel)]) &
                          255U);
}

TEST(ScaledPixels, areTheSameAtTheSameSize) {
  const auto rgba = noise(7, 5);
  std::vector<uint32_t> found;
  scalePixels(rgba, 7, 5, 7, 5, found);
  ASSERT_EQ(found.size(), 35U);
  for (size_t i = 0; i < rgba.size(); ++i)
    EXPECT_EQ(channelOf(found[i / 4], static_cast<int>(i % 4)), rgba[i]);
}

TEST(ScaledPixels, areThoseOfAPlainFilter) {
  constexpr std::array<std::array<int, 4>, 6> kSizes{{{13, 9, 50, 41},
                                                      {1, 1, 8, 3},
                                                      {5, 1, 20, 20},
                                                      {100, 75, 333, 250},
                                                      {40, 30, 17, 11},
                                                      {2, 3, 3, 2}}};
  for (const auto& [from_width, from_height, width, height] : kSizes) {
    const auto rgba = noise(from_width, from_height);
    std::vector<uint32_t> found{1, 2, 3};
    scalePixels(rgba, from_width, from_height, width, height, found);
    ASSERT_EQ(found.size(), static_cast<size_t>(width) * static_cast<size_t>(height));
    double largest = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int channel = 0; channel < 4; ++channel) {
          // Each of the four nearest by its distance; edges go on.
          const double at_x = (x + 0.5) * from_width / width - 0.5,
                       at_y = (y + 0.5) * from_height / height - 0.5;
          double sum = 0;
          for (int dy = 0; dy < 2; ++dy)
            for (int dx = 0; dx < 2; ++dx) {
              const int near_x = static_cast<int>(std::floor(at_x)) + dx,
                        near_y = static_cast<int>(std::floor(at_y)) + dy;
              const double weight = (1 - std::abs(at_x - near_x)) * (1 - std::abs(at_y - near_y));
              const int kept_x = std::clamp(near_x, 0, from_width - 1),
                        kept_y = std::clamp(near_y, 0, from_height - 1);
              sum +=
                  weight * rgba[static_cast<size_t>((kept_y * from_width + kept_x) * 4 + channel)];
            }
          const int made = channelOf(found[static_cast<size_t>(y * width + x)], channel);
          largest = std::max(largest, std::abs(made - sum));
        }
    EXPECT_LE(largest, 2.0) << from_width << " x " << from_height << " to " << width << " x "
                            << height;
  }
}

TEST(MixedPixels, goFromOnePictureToTheOther) {
  const auto from = noise(37, 5), to = noise(5, 37);
  std::vector<uint32_t> a, b, mixed;
  scalePixels(from, 37, 5, 37, 5, a);
  scalePixels(to, 5, 37, 5, 37, b);
  std::ranges::reverse(b);
  ASSERT_NE(a, b);
  mixPixels(a, b, 0, mixed);
  EXPECT_EQ(mixed, a);
  mixPixels(a, b, 1, mixed);
  EXPECT_EQ(mixed, b);
  for (const double share : {0.01, 0.3, 0.5, 0.99}) {
    mixPixels(a, b, share, mixed);
    for (size_t i = 0; i < a.size(); ++i)
      for (int channel = 0; channel < 4; ++channel)
        EXPECT_NEAR(channelOf(mixed[i], channel),
                    (1 - share) * channelOf(a[i], channel) + share * channelOf(b[i], channel), 1.5);
  }
}

}  // namespace
}  // namespace sluice
