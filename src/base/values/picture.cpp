#include "src/base/values/picture.h"

#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

uint8_t toByte(float value) {
  if (!(value > 0)) return 0;
  if (value >= 1) return 255;
  return static_cast<uint8_t>(std::lround(value * 255));
}

float linearOf(float shown) {
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
  Rgba8Picture result{picture.width, picture.height, std::vector<uint8_t>(picture.rgba.size())};
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    const float alpha = picture.rgba[i + 3];
    if (!(alpha > 0)) continue;
    for (size_t c = 0; c < 3; ++c) result.rgba[i + c] = toByte(picture.rgba[i + c] / alpha);
    result.rgba[i + 3] = toByte(alpha);
  }
  return result;
}

Picture toLinearLight(const Picture& picture) {
  check(picture);
  Picture result = picture;
  for (size_t i = 0; i < result.rgba.size(); i += 4) {
    const float alpha = result.rgba[i + 3];
    if (!(alpha > 0)) continue;
    for (size_t c = 0; c < 3; ++c)
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
