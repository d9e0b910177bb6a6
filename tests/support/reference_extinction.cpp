#include "tests/support/reference_extinction.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace sluice {
namespace {

std::array<double, 4> extinctionAt(const TransferFunction& transfer, double value) {
  const double opacity = opacityAt(transfer, value);
  const double extinction = opacity < 1 ? std::min(-std::log2(1 - opacity), 16.0) : 16;
  const Vec3d rgb = colorAt(transfer, value) * extinction;
  return {rgb.x, rgb.y, rgb.z, extinction};
}

}  // namespace

std::array<double, 4> meanExtinction(const TransferFunction& transfer, double from, double to) {
  if (from > to) std::swap(from, to);
  if (!(to - from > 1e-9 * (std::abs(from) + std::abs(to)))) return extinctionAt(transfer, from);
  std::vector<double> ends{from, to};
  const auto cut = [&](const auto& points) {
    for (const auto& point : points)
      if (point.value > from && point.value < to) ends.push_back(point.value);
  };
  cut(transfer.opacities);
  cut(transfer.colors);
  std::sort(ends.begin(), ends.end());
  constexpr int kPieces = 6;
  constexpr double kAside = 0.3872983346207417, kWeights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  std::array<double, 4> mean{};
  for (size_t i = 0; i + 1 < ends.size(); ++i) {
    const double width = (ends[i + 1] - ends[i]) / kPieces;
    for (int piece = 0; piece < kPieces && width > 0; ++piece)
      for (int place = 0; place < 3; ++place) {
        const double at = ends[i] + (piece + 0.5 + (place - 1) * kAside) * width;
        const auto extinction = extinctionAt(transfer, at);
        for (size_t c = 0; c < 4; ++c)
          mean[c] += extinction[c] * kWeights[place] * width / (to - from);
      }
  }
  return mean;
}

}  // namespace sluice
