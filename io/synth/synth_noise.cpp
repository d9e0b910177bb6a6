// Clouds: the part of a value noise of four octaves that rises above a threshold. The threshold is
// the quantile of a seeded sample of the field, so that a chosen share of the voxels remains.
#include <algorithm>
#include <array>

#include "io/synth/synth_fields.h"
#include "io/synth/synth_math.h"

namespace sluice {
namespace {

constexpr int kOctaves = 4;
constexpr int kSamples = 32768;
// The share of the sample that is brighter than 1, and clipped.
constexpr double kBrightest = 0.002;

constexpr float smoothStep(float t) {
  return t * t * (3 - 2 * t);
}

class NoiseField : public SynthField {
 public:
  explicit NoiseField(const SynthOptions& options)
      : SynthField(options.dims), seed_(hash64(options.seed)) {
    // The largest octave has eight or more cells along the longest axis, of 8 voxels or more.
    const int64_t longest = std::max({options.dims.x, options.dims.y, options.dims.z});
    int64_t cell = 8;
    while (cell * 16 <= longest) cell *= 2;
    float amplitude = 1 / 1.875F;
    for (Octave& octave : octaves_) {
      octave.cell = cell;
      octave.amplitude = amplitude;
      for (int64_t i = 0; i < cell; ++i)
        octave.weights.push_back(smoothStep(static_cast<float>(i) / static_cast<float>(cell)));
      cell /= 2;
      amplitude /= 2;
    }
    findThreshold(options);
  }

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    fillRaw(y, z, x0, row);
    float largest = 0;
    for (float& value : row) {
      value = std::clamp((value - threshold_) * gain_, 0.0F, 1.0F);
      largest = std::max(largest, value);
    }
    return largest > 0;
  }

 private:
  struct Octave {
    int64_t cell = 0;  // voxels
    float amplitude = 0;
    std::vector<float> weights;  // smooth step from one lattice point to the next, a voxel each
  };

  // The noise itself, 0..1.
  void fillRaw(int64_t y, int64_t z, int64_t x0, std::span<float> row) const {
    std::fill(row.begin(), row.end(), 0.0F);
    const int64_t end = x0 + static_cast<int64_t>(row.size());
    for (size_t o = 0; o < octaves_.size(); ++o) {
      const Octave& octave = octaves_[o];
      int64_t cell = x0 / octave.cell;
      float left = latticeAt(o, cell, y, z);
      for (int64_t x = x0; x < end; ++cell) {
        const float right = latticeAt(o, cell + 1, y, z);
        const int64_t start = cell * octave.cell, stop = std::min(start + octave.cell, end);
        const float step = right - left;
        for (; x < stop; ++x)
          row[static_cast<size_t>(x - x0)] +=
              left + step * octave.weights[static_cast<size_t>(x - start)];
        left = right;
      }
    }
  }

  // Octave o's lattice values at x = cell, interpolated over y and z, times the amplitude.
  float latticeAt(size_t o, int64_t cell, int64_t y, int64_t z) const {
    const Octave& octave = octaves_[o];
    const int64_t cy = y / octave.cell, cz = z / octave.cell;
    const float wy = octave.weights[static_cast<size_t>(y - cy * octave.cell)];
    const float wz = octave.weights[static_cast<size_t>(z - cz * octave.cell)];
    const auto at = [&](int64_t dy, int64_t dz) {
      return static_cast<float>(unitFrom(hash64(seed_ + o, cell, cy + dy, cz + dz)));
    };
    const auto along_y = [&](int64_t dz) {
      const float a = at(0, dz);
      return a + wy * (at(1, dz) - a);
    };
    const float a = along_y(0);
    return octave.amplitude * (a + wz * (along_y(1) - a));
  }

  void findThreshold(const SynthOptions& options) {
    std::vector<float> sample(kSamples);
    for (size_t i = 0; i < sample.size(); ++i) {
      Vec3i at;
      for (int a = 0; a < 3; ++a)
        at[a] = static_cast<int64_t>(unitFrom(hash64(seed_, static_cast<int64_t>(i), a, -1)) *
                                     static_cast<double>(options.dims[a]));
      fillRaw(at.y, at.z, at.x, std::span(&sample[i], 1));
    }
    std::sort(sample.begin(), sample.end());
    const auto quantile = [&](double share_above) {
      const auto index = static_cast<int64_t>((1 - share_above) * kSamples);
      return sample[static_cast<size_t>(std::clamp<int64_t>(index, 0, kSamples - 1))];
    };
    threshold_ = options.object_share >= 1 ? -1e-3F : quantile(options.object_share);
    const float brightest =
        std::max(quantile(std::min(kBrightest, options.object_share / 4)), threshold_ + 1e-3F);
    gain_ = 1 / (brightest - threshold_);
  }

  const uint64_t seed_;
  std::array<Octave, kOctaves> octaves_;  // constant after construction
  float threshold_ = 0, gain_ = 1;        // constant after construction
};

}  // namespace

std::unique_ptr<SynthField> makeNoiseField(const SynthOptions& options) {
  return std::make_unique<NoiseField>(options);
}

}  // namespace sluice
