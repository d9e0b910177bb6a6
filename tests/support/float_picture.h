// FloatPicture: the reference renderer's result, and the comparison of pictures.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace sluice {

struct FloatPicture {
  int width = 0, height = 0;
  std::vector<float> rgba;   // premultiplied, row 0 on top, 4 floats a pixel
  std::vector<float> depth;  // world units along the view, 0 if the picture is transparent
  // By how much rounding may change a channel of each pixel, of 1; empty: by nothing that counts.
  std::vector<float> doubt = {};

  std::array<float, 4> at(int x, int y) const;
};

// Differences in units of 1/255, over all channels, after clamping both to 0..1; NaN differs by
// 255.
struct Difference {
  double max_255 = 0, mean_255 = 0;
  int pixels_over = 0;           // pixels with a channel that differs by more than the tolerance
  int worst_x = 0, worst_y = 0;  // pixel of the maximum
};

// The largest difference of a pixel's channels, as below.
double difference255(std::span<const float> a, std::span<const float> b, size_t pixel);

// Requires: both hold 4 * width * height floats for some height.
Difference compare(std::span<const float> a, std::span<const float> b, int width,
                   double tolerance_255 = 1);
// Requires: equal sizes.
Difference compare(const FloatPicture& a, const FloatPicture& b, double tolerance_255 = 1);

}  // namespace sluice
