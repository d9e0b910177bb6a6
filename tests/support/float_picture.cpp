#include "tests/support/float_picture.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {

std::array<float, 4> FloatPicture::at(int x, int y) const {
  SLUICE_CHECK(x >= 0 && x < width && y >= 0 && y < height);
  const float* p =
      rgba.data() +
      (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * 4;
  return {p[0], p[1], p[2], p[3]};
}

namespace {

double channelDifference255(float a, float b) {
  const double d = 255 * std::abs(std::clamp(static_cast<double>(a), 0.0, 1.0) -
                                  std::clamp(static_cast<double>(b), 0.0, 1.0));
  return std::isnan(d) ? 255 : d;
}

}  // namespace

double difference255(std::span<const float> a, std::span<const float> b, size_t pixel) {
  double largest = 0;
  for (size_t i = 4 * pixel; i < 4 * pixel + 4; ++i)
    largest = std::max(largest, channelDifference255(a[i], b[i]));
  return largest;
}

Difference compare(std::span<const float> a, std::span<const float> b, int width,
                   double tolerance_255) {
  SLUICE_CHECK_EQ(a.size(), b.size());
  SLUICE_CHECK(width > 0 && a.size() % (4 * static_cast<size_t>(width)) == 0);
  Difference result;
  double sum = 0, worst = -1;
  for (size_t pixel = 0; pixel < a.size() / 4; ++pixel) {
    for (size_t i = 4 * pixel; i < 4 * pixel + 4; ++i) sum += channelDifference255(a[i], b[i]);
    const double largest = difference255(a, b, pixel);
    if (largest > tolerance_255) ++result.pixels_over;
    if (largest > worst) {
      worst = largest;
      result.worst_x = static_cast<int>(pixel % static_cast<size_t>(width));
      result.worst_y = static_cast<int>(pixel / static_cast<size_t>(width));
    }
  }
  result.max_255 = std::max(worst, 0.0);
  result.mean_255 = a.empty() ? 0 : sum / static_cast<double>(a.size());
  return result;
}

Difference compare(const FloatPicture& a, const FloatPicture& b, double tolerance_255) {
  SLUICE_CHECK_EQ(a.width, b.width);
  SLUICE_CHECK_EQ(a.height, b.height);
  return compare(a.rgba, b.rgba, a.width, tolerance_255);
}

}  // namespace sluice
