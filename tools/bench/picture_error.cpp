#include "tools/bench/picture_error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

// Wang 2004, section III-B, weights 11 x 11 pixels by a Gaussian with a deviation of 1.5.
constexpr int kReach = 5;  // pixels to either side
constexpr double kDeviation = 1.5;

// A plane of numbers, a row after the other.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;
};

Plane planeOf(const Picture& picture, const std::function<double(size_t pixel)>& value) {
  Plane plane{picture.width, picture.height, {}};
  for (size_t pixel = 0; pixel < picture.rgba.size() / 4; ++pixel)
    plane.values.push_back(value(pixel));
  return plane;
}

// Along rows, then transposed: twice is both ways. Beyond the border the window has no weight.
Plane blurredAcross(const Plane& plane) {
  Plane result{plane.height, plane.width, std::vector<double>(plane.values.size())};
  for (int y = 0; y < plane.height; ++y)
    for (int x = 0; x < plane.width; ++x) {
      double sum = 0, weights = 0;
      for (int i = std::max(0, x - kReach); i <= std::min(plane.width - 1, x + kReach); ++i) {
        const double weight = std::exp(-0.5 * std::pow((i - x) / kDeviation, 2));
        sum += weight * plane.values[static_cast<size_t>(y) * static_cast<size_t>(plane.width) +
                                     static_cast<size_t>(i)];
        weights += weight;
      }
      result.values[static_cast<size_t>(x) * static_cast<size_t>(plane.height) +
                    static_cast<size_t>(y)] = sum / weights;
    }
  return result;
}

double ssimOf(const Picture& a, const Picture& b, size_t channel) {
  const auto blurred = [&](const std::function<double(double, double)>& f) {
    return blurredAcross(blurredAcross(planeOf(a, [&](size_t pixel) {
      const size_t at = 4 * pixel + channel;
      return f(static_cast<double>(a.rgba[at]), static_cast<double>(b.rgba[at]));
    })));
  };
  const Plane mean_a = blurred([](double x, double) { return x; });
  const Plane mean_b = blurred([](double, double y) { return y; });
  const Plane aa = blurred([](double x, double) { return x * x; });
  const Plane bb = blurred([](double, double y) { return y * y; });
  const Plane ab = blurred([](double x, double y) { return x * y; });
  // K1 = 0.01 and K2 = 0.03 of Wang 2004 keep quotients of dark and of even parts finite.
  constexpr double kOne = 0.01 * 0.01, kTwo = 0.03 * 0.03;  // of a range of 1
  double sum = 0;
  for (size_t i = 0; i < aa.values.size(); ++i) {
    const double x = mean_a.values[i], y = mean_b.values[i];
    const double xx = aa.values[i] - x * x, yy = bb.values[i] - y * y, xy = ab.values[i] - x * y;
    sum += (2 * x * y + kOne) * (2 * xy + kTwo) / ((x * x + y * y + kOne) * (xx + yy + kTwo));
  }
  return sum / static_cast<double>(aa.values.size());
}

// The squares of what the blur takes from red, green and blue, of each pixel.
std::vector<double> detailOf(const Picture& picture) {
  std::vector<double> squares(picture.rgba.size() / 4);
  for (size_t channel = 0; channel < 3; ++channel) {
    const Plane plane = planeOf(picture, [&](size_t pixel) {
      return static_cast<double>(picture.rgba[4 * pixel + channel]);
    });
    const Plane blurred = blurredAcross(blurredAcross(plane));
    for (size_t i = 0; i < squares.size(); ++i)
      squares[i] += std::pow(plane.values[i] - blurred.values[i], 2) / 3;
  }
  return squares;
}

void compareDetail(const Picture& picture, const Picture& truth, PictureError& error) {
  const std::vector<double> found = detailOf(picture), expected = detailOf(truth);
  std::vector<size_t> smooth;
  for (size_t i = 0; i < expected.size(); ++i)
    if (truth.rgba[4 * i + 3] > 0) smooth.push_back(i);
  std::ranges::stable_sort(smooth, {}, [&](size_t i) { return expected[i]; });
  // Parts are smooth if the truth is: detail on edges is no fault.
  smooth.resize((smooth.size() + 1) / 2);
  if (smooth.empty()) return;
  const auto rootMean = [&](const std::vector<double>& squares) {
    double sum = 0;
    for (const size_t i : smooth) sum += squares[i];
    return 255 * std::sqrt(sum / static_cast<double>(smooth.size()));
  };
  error.detail = rootMean(found);
  error.truth_detail = rootMean(expected);
}

double meanOpacity(const Picture& picture) {
  double sum = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) sum += static_cast<double>(picture.rgba[i]);
  const size_t pixels = picture.rgba.size() / 4;
  return sum / static_cast<double>(pixels);
}

}  // namespace

PictureError pictureError(const Picture& picture, const Picture& truth) {
  SLUICE_CHECK_EQ(picture.width, truth.width);
  SLUICE_CHECK_EQ(picture.height, truth.height);
  PictureError error;
  for (size_t i = 0; i < picture.rgba.size(); ++i) {
    const double difference =
        255 * std::abs(static_cast<double>(picture.rgba[i]) - static_cast<double>(truth.rgba[i]));
    error.max = std::max(error.max, difference);
    error.mean += difference / static_cast<double>(picture.rgba.size());
  }
  for (size_t channel = 0; channel < 3; ++channel)
    error.ssim += ssimOf(picture, truth, channel) / 3;
  const double opacity = meanOpacity(truth);
  const double difference = std::abs(meanOpacity(picture) - opacity);
  error.mean_opacity = opacity > 0 ? difference / opacity : difference;
  compareDetail(picture, truth, error);
  return error;
}

Picture averagedDown(const Picture& picture, int times) {
  SLUICE_CHECK(picture.width % times == 0 && picture.height % times == 0);
  Picture result;
  result.width = picture.width / times;
  result.height = picture.height / times;
  result.rgba.resize(picture.rgba.size() / static_cast<size_t>(times * times));
  const auto from = static_cast<size_t>(picture.width), to = static_cast<size_t>(result.width);
  const auto side = static_cast<size_t>(times);
  const float share = 1 / static_cast<float>(times * times);
  for (size_t pixel = 0; pixel < picture.rgba.size() / 4; ++pixel) {
    const size_t x = pixel % from / side, y = pixel / from / side;
    for (size_t channel = 0; channel < 4; ++channel)
      result.rgba[4 * (y * to + x) + channel] += share * picture.rgba[4 * pixel + channel];
  }
  return result;
}

}  // namespace sluice
