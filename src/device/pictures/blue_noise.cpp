// The void-and-cluster method (R. Ulichney, "The void-and-cluster method for dither array
// generation", 1993): pixels get their ranks one after the other, each where those that have one
// are farthest away. Their energies are whole numbers, so that no compiler's rounding changes the
// order.
#include "src/device/pictures/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

namespace sluice {
namespace {

constexpr int kSide = kBlueNoiseSide, kPixels = kSide * kSide;
constexpr int kFirst = kPixels / 10;  // pixels of the first pattern
constexpr double kSigma = 1.5;        // of the energy around a pixel, in pixels
constexpr uint32_t kSeed = 1993;

class Pattern {
 public:
  Pattern() : around_(kPixels), energy_(kPixels), is_set_(kPixels) {
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        // Distances wrap around the edges: the mask repeats without a seam.
        const int dx = std::min(x, kSide - x), dy = std::min(y, kSide - y);
        const double share = std::exp(-(dx * dx + dy * dy) / (2 * kSigma * kSigma));
        around_[indexOf(x, y)] = std::llround(share * (1 << 24));
      }
  }

  bool isSet(int pixel) const { return is_set_[static_cast<size_t>(pixel)]; }
  void set(int pixel, bool is_set) {
    is_set_[static_cast<size_t>(pixel)] = is_set;
    const int64_t sign = is_set ? 1 : -1;
    const int px = pixel % kSide, py = pixel / kSide;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        energy_[indexOf(x, y)] +=
            sign * around_[indexOf((x - px + kSide) % kSide, (y - py + kSide) % kSide)];
  }
  // The set pixel that has most others around it, and the unset one that has fewest.
  int tightestCluster() const { return best(true, 1); }
  int largestVoid() const { return best(false, -1); }

 private:
  static size_t indexOf(int x, int y) {
    return static_cast<size_t>(y) * kSide + static_cast<size_t>(x);
  }
  int best(bool of_set, int64_t sign) const {
    int found = -1;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
      if (isSet(pixel) != of_set) continue;
      // The first of equals is taken, so that the order is the same everywhere.
      if (found < 0 ||
          sign * energy_[static_cast<size_t>(pixel)] > sign * energy_[static_cast<size_t>(found)])
        found = pixel;
    }
    return found;
  }

  std::vector<int64_t> around_, energy_;
  std::vector<bool> is_set_;
};

// The first pattern: some pixels, moved from clusters to voids until none moves any more.
Pattern firstPattern() {
  Pattern pattern;
  std::mt19937 random(kSeed);
  for (int left = kFirst; left > 0;) {
    // The standard fixes the numbers of mt19937, but not those of its distributions.
    const auto pixel = static_cast<int>(random() % kPixels);
    if (pattern.isSet(pixel)) continue;
    pattern.set(pixel, true);
    --left;
  }
  for (;;) {
    const int cluster = pattern.tightestCluster();
    pattern.set(cluster, false);
    const int gap = pattern.largestVoid();
    pattern.set(gap, true);
    // The pixel that was taken away left the largest gap: nothing moves any more.
    if (gap == cluster) return pattern;
  }
}

std::vector<float> makeNoise() {
  const Pattern first = firstPattern();
  std::vector<float> noise(kPixels);
  const auto rank = [&](int pixel, int at) {
    noise[static_cast<size_t>(pixel)] =
        (static_cast<float>(at) + 0.5F) / static_cast<float>(kPixels) - 0.5F;
  };
  // The first pattern's pixels get the lower ranks, the one in the tightest cluster the highest of
  // these.
  Pattern fewer = first;
  for (int at = kFirst - 1; at >= 0; --at) {
    const int pixel = fewer.tightestCluster();
    fewer.set(pixel, false);
    rank(pixel, at);
  }
  // A pixel of the void with fewest set ones around it has most unset ones around it, so that the
  // second half of the method needs no rule of its own.
  Pattern more = first;
  for (int at = kFirst; at < kPixels; ++at) {
    const int pixel = more.largestVoid();
    more.set(pixel, true);
    rank(pixel, at);
  }
  return noise;
}

}  // namespace

const std::vector<float>& blueNoise() {
  static const std::vector<float> noise = makeNoise();
  return noise;
}

}  // namespace sluice
