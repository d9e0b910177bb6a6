// A layer in which a heavy gas below and a light one above mix, in the manner of the instability of
// Richtmyer and Meshkov: an interface of many waves, the short ones of which saturate early while
// the long ones go on growing. Their crests roll up, and fine texture appears between the gases.
// Outside the layer all is constant, and a block there is the same at each step until the layer
// reaches it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "io/synth/synth_fields.h"
#include "io/synth/synth_math.h"

namespace sluice {
namespace {

constexpr float kHeavy = 0.75F;         // the gas below; the light one is 0
constexpr int kWaves = 20;              // waves of the interface
constexpr int kSwirls = 5;              // vortices that roll up its crests
constexpr double kMeetStep = 1.0 / 64;  // the mixing's time per step; at 1 the layer is half grown
constexpr double kGreatestHeight = 0.045;  // a wave's amplitude in heights of the volume at time 1
constexpr double kEdge = 0.012;            // thickness of the interface
constexpr float kLayerTexture = 0.2F;
constexpr int kSineEntries = 4096;

// sin(2 pi t) by linear interpolation: an interface needs no more, and a voxel takes many.
class SineTable {
 public:
  SineTable() {
    for (int i = 0; i <= kSineEntries; ++i)
      values_[static_cast<size_t>(i)] =
          static_cast<float>(sineOfTurns(static_cast<double>(i) / kSineEntries));
  }
  float operator()(float turns) const {
    const float at = (turns - std::floor(turns)) * kSineEntries;
    const auto entry = std::min(static_cast<size_t>(at), static_cast<size_t>(kSineEntries - 1));
    const float part = at - static_cast<float>(entry);
    return values_[entry] + part * (values_[entry + 1] - values_[entry]);
  }

 private:
  std::array<float, kSineEntries + 1> values_{};
};

// Carries its surroundings along x and y; periods across the volume.
struct Swirl {
  Vec3<float> periods;
  float phase = 0;
  float along_x = 0, along_y = 0;
};

// A wave has whole periods across the volume, so that opposite sides meet.
struct Wave {
  float periods_x = 0, periods_y = 0, phase = 0;
  float greatest = 0;  // amplitude at which it saturates
  float rate = 0;      // amplitude a unit of time before
};

class MixingField : public SynthField {
 public:
  explicit MixingField(const SynthOptions& options)
      : SynthField(options.dims), dims_(toDouble(options.dims)), texture_(options.seed) {
    for (int i = 0; i < kWaves; ++i) {
      const auto random = [&](int k) { return unitFrom(hash64(hash64(options.seed), i, k, 11)); };
      // A wave has 2 to 14 periods: long waves are few, high and late.
      const double periods = 2 + 12.0 * i / (kWaves - 1);
      const double turns = random(0);
      Wave& wave = waves_[static_cast<size_t>(i)];
      wave.periods_x = static_cast<float>(std::floor(periods * cosineOfTurns(turns) + 0.5));
      wave.periods_y = static_cast<float>(std::floor(periods * sineOfTurns(turns) + 0.5));
      wave.phase = static_cast<float>(random(1));
      wave.greatest = static_cast<float>(kGreatestHeight * 4 / (2 + periods));
      wave.rate = static_cast<float>(kGreatestHeight * (0.25 + 0.04 * periods));
    }
    for (int i = 0; i < kSwirls; ++i) {
      const auto random = [&](int k) { return unitFrom(hash64(hash64(options.seed), i, k, 13)); };
      Swirl& swirl = swirls_[static_cast<size_t>(i)];
      for (int a = 0; a < 3; ++a)
        swirl.periods[a] = static_cast<float>(std::floor((random(a) - 0.5) * 12 + 0.5));
      swirl.phase = static_cast<float>(random(3));
      const double turns = random(4);
      swirl.along_x = static_cast<float>(cosineOfTurns(turns));
      swirl.along_y = static_cast<float>(sineOfTurns(turns));
    }
  }

  bool fillRow(int64_t time, int64_t y, int64_t z, int64_t x0,
               std::span<float> row) const override {
    const Grown grown = grownTo(time);
    const auto above = static_cast<float>((static_cast<double>(z) + 0.5) / dims_.z - 0.5);
    if (above >= grown.reach) return false;
    if (above <= -grown.reach) {
      std::fill(row.begin(), row.end(), kHeavy);
      return true;
    }
    std::fill(row.begin(), row.end(), 0.0F);
    // The tile repeats every 64 voxels of a volume of any size: eddies of a fixed number of voxels.
    texture_.add(row, x0, y, z, kLayerTexture);
    const auto at_y = static_cast<float>((static_cast<double>(y) + 0.5) / dims_.y);
    for (size_t i = 0; i < row.size(); ++i) {
      const auto x =
          static_cast<float>((static_cast<double>(x0 + static_cast<int64_t>(i)) + 0.5) / dims_.x);
      // Crests roll up: higher and lower parts are carried aside.
      float carried_x = x, carried_y = at_y;
      for (const Swirl& swirl : swirls_) {
        const float aside = grown.swirl * sine_(swirl.periods.x * x + swirl.periods.y * at_y +
                                                swirl.periods.z * above + swirl.phase);
        carried_x += aside * swirl.along_x;
        carried_y += aside * swirl.along_y;
      }
      float height = above;
      for (size_t w = 0; w < kWaves; ++w)
        height -= grown.amplitudes[w] * sine_(waves_[w].periods_x * carried_x +
                                              waves_[w].periods_y * carried_y + waves_[w].phase);
      row[i] = valueAt(height, above / grown.reach, row[i]);
    }
    return true;
  }

 private:
  // Quantities that grow with time alone.
  struct Grown {
    std::array<float, kWaves> amplitudes{};
    float swirl = 0;
    float reach = 0;  // beyond it above and below the middle all is one gas
  };

  Grown grownTo(int64_t time) const {
    const double t = kMeetStep * static_cast<double>(time + 1);
    Grown grown;
    grown.swirl = static_cast<float>(0.045 * t / (0.5 + t));
    double sum = kEdge;
    for (size_t w = 0; w < kWaves; ++w) {
      const double linear = static_cast<double>(waves_[w].rate) * t;
      const auto greatest = static_cast<double>(waves_[w].greatest);
      grown.amplitudes[w] = static_cast<float>(linear * greatest / (linear + greatest));
      sum += static_cast<double>(grown.amplitudes[w]);
    }
    grown.reach = static_cast<float>(std::min(sum, 0.5));
    return grown;
  }

  // `height` above the interface, `in_layer` -1..1 across the layer, `texture` within
  // kLayerTexture.
  static float valueAt(float height, float in_layer, float texture) {
    const float t = std::clamp(0.5F - height / static_cast<float>(2 * kEdge), 0.0F, 1.0F);
    const float heavy = t * t * (3 - 2 * t);
    if (heavy == 0) return 0;
    // The share of mixed gas: greatest in the middle of the layer.
    const float met = 1 - in_layer * in_layer;
    return std::clamp(heavy * (kHeavy + met * texture), 0.0F, 1.0F);
  }

  const Vec3d dims_;
  const SineTable sine_;
  const TextureTile texture_;
  // Constant after construction.
  std::array<Wave, kWaves> waves_;
  std::array<Swirl, kSwirls> swirls_;
};

}  // namespace

std::unique_ptr<SynthField> makeMixingField(const SynthOptions& options) {
  return std::make_unique<MixingField>(options);
}

}  // namespace sluice
