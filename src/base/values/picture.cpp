#include "src/base/values/picture.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

// Rounds as std::lround() does, but without a call or a branch, so that loops of it become vector
// instructions: the difference to the whole part is exact.
uint8_t toByte(float value) {
  const float over_0 = value > 0 ? value : 0;  // not-a-number, too
  const float level = (over_0 < 1 ? over_0 : 1) * 255;
  const auto whole = static_cast<int>(level);
  return static_cast<uint8_t>(whole + (level - static_cast<float>(whole) >= 0.5F ? 1 : 0));
}

float linearOf(float shown) {
  // The transfer function of sRGB (IEC 61966-2-1).
  constexpr float kLinearPart = 0.04045F;
  return shown <= kLinearPart ? shown / 12.92F : std::pow((shown + 0.055F) / 1.055F, 2.4F);
}

void check(const Picture& picture) {
  SLUICE_CHECK(picture.width > 0 && picture.height > 0);
  SLUICE_CHECK_EQ(picture.rgba.size(), size_t{4} * static_cast<size_t>(picture.width) *
                                           static_cast<size_t>(picture.height));
}

}  // namespace

Rgba8Picture toRgba8(const Picture& picture) {
  check(picture);
  return {picture.width, picture.height, rgba8(picture.rgba)};
}

std::vector<uint8_t> rgba8(std::span<const float> rgba) {
  SLUICE_CHECK_EQ(rgba.size() % 4, 0U);
  std::vector<uint8_t> bytes(rgba.size());
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    // A transparent pixel has no colour to divide by its opacity.
    if (!(alpha > 0)) continue;
    for (size_t c = 0; c < 3; ++c) bytes[i + c] = toByte(rgba[i + c] / alpha);
    bytes[i + 3] = toByte(alpha);
  }
  return bytes;
}

std::vector<uint8_t> rgba8Over(std::span<const float> rgba, std::array<float, 3> background_rgb) {
  SLUICE_CHECK_EQ(rgba.size() % 4, 0U);
  // Small enough to stay in the first cache between the two loops.
  constexpr size_t kPiece = 4096;
  std::array<float, kPiece> mixed;
  const std::array<float, 4> background{background_rgb[0], background_rgb[1], background_rgb[2], 0};
  std::vector<uint8_t> bytes(rgba.size());
  for (size_t begin = 0; begin < rgba.size(); begin += kPiece) {
    const size_t count = std::min(kPiece, rgba.size() - begin);
    const float* from = rgba.data() + begin;
    for (size_t i = 0; i < count; i += 4) {
      const float through = 1 - from[i + 3];
      for (size_t c = 0; c < 4; ++c) mixed[i + c] = from[i + c] + through * background[c];
      mixed[i + 3] = 1;
    }
    uint8_t* to = bytes.data() + begin;
    for (size_t i = 0; i < count; ++i) to[i] = toByte(mixed[i]);
  }
  return bytes;
}

Picture toLinearLight(const Picture& picture) {
  check(picture);
  Picture result = picture;
  for (size_t i = 0; i < result.rgba.size(); i += 4) {
    const float alpha = result.rgba[i + 3];
    if (!(alpha > 0)) continue;
    for (size_t c = 0; c < 3; ++c)
      // The curve holds for the colour itself, so that it is not premultiplied in between.
      result.rgba[i + c] = linearOf(result.rgba[i + c] / alpha) * alpha;
  }
  return result;
}

Picture over(const Picture& picture, std::array<float, 3> background_rgb) {
  check(picture);
  Picture result = picture;
  for (size_t i = 0; i < result.rgba.size(); i += 4) {
    const float through = 1 - result.rgba[i + 3];
    for (size_t c = 0; c < 3; ++c) result.rgba[i + c] += through * background_rgb[c];
    result.rgba[i + 3] = 1;
  }
  return result;
}

}  // namespace sluice
