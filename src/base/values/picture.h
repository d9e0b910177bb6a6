// Picture: the result of rendering, in floats, and its conversion to 8 bits.
//
// Plain values. Row 0 is the top row, x grows to the right; pixels are packed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

struct Picture {
  int width = 0, height = 0;
  std::vector<float> rgba;   // width * height * 4, red first, premultiplied by alpha; sRGB as shown
  std::vector<float> depth;  // width * height, or empty
};

// 8 bits a channel, straight alpha, as PNG stores it.
struct Rgba8Picture {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;  // width * height * 4
};

// Divides by alpha, clamps to 0..1 (not-a-number becomes 0) and rounds to the nearest of 256. The
// color is 0 if alpha is 0.
Rgba8Picture toRgba8(const Picture& picture);

// The same bytes for packed pixels: straight alpha, or over an opaque background, as
// toRgba8(over(picture, background_rgb)) gives them, without a copy of the picture.
std::vector<uint8_t> rgba8(std::span<const float> rgba);
std::vector<uint8_t> rgba8Over(std::span<const float> rgba, std::array<float, 3> background_rgb);

// The same picture in linear light: the transfer function of sRGB (IEC 61966-2-1) is undone on the
// colours, which are then premultiplied again. Alpha and depth are kept.
Picture toLinearLight(const Picture& picture);

// The picture over an opaque background: alpha is 1 everywhere, depth is kept.
Picture over(const Picture& picture, std::array<float, 3> background_rgb);

}  // namespace sluice
