// Vortex rings as strings of soft particles that an Arnold-Beltrami-Childress flow carries along:
// a time-varying scalar whose neighbouring steps are much alike and that is empty in most places.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "io/synth/synth_fields.h"
#include "io/synth/synth_math.h"

namespace sluice {
namespace {

constexpr int kRings = 12;
constexpr int kParticlesOfRing = 24;
constexpr size_t kParticles = kRings * kParticlesOfRing;
constexpr double kReach = 0.045;    // a particle's radius; the volume is [0, 1)^3, periodic
constexpr double kTimeStep = 0.01;  // the flow's time per step
constexpr double kStrength = 0.55;  // value at a particle's centre; neighbours add up

// The particles of a step, and for each slice of z those that reach into it, so that a row asks few
// of them. They are in ascending order, so that a voxel's sum is always added up in the same order.
constexpr int kSlices = 32;
struct Step {
  std::array<Vec3<float>, kParticles> particles;
  std::array<std::vector<uint16_t>, kSlices> reaching;
};

// Velocity in periods of the volume, A = sqrt 3, B = sqrt 2, C = 1 over 2 pi.
Vec3d velocityAt(Vec3d p) {
  constexpr double kA = 0.2756644477108960, kB = 0.2250790790392765, kC = 0.1591549430918953;
  return {kA * sineOfTurns(p.z) + kC * cosineOfTurns(p.y),
          kB * sineOfTurns(p.x) + kA * cosineOfTurns(p.z),
          kC * sineOfTurns(p.y) + kB * cosineOfTurns(p.x)};
}

Vec3d advanced(Vec3d p) {
  // Heun's rule: enough for particles that only have to look carried.
  const Vec3d first = velocityAt(p);
  const Vec3d second = velocityAt(p + first * kTimeStep);
  return p + (first + second) * (kTimeStep / 2);
}

double wrapped(double x) {
  return x - std::floor(x);
}

std::array<Vec3d, kParticles> startingParticles(uint64_t seed) {
  std::array<Vec3d, kParticles> particles;
  for (int ring = 0; ring < kRings; ++ring) {
    const auto random = [&](int i) { return unitFrom(hash64(hash64(seed), ring, i, 7)); };
    const Vec3d center = {random(0), random(1), random(2)};
    const Vec3d pole = normalized({random(3) - 0.5, random(4) - 0.5, random(5) - 0.4999});
    const Vec3d aside = std::abs(pole.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d u = normalized(cross(pole, aside)), v = cross(pole, u);
    const double radius = 0.07 + 0.08 * random(6);
    for (int i = 0; i < kParticlesOfRing; ++i) {
      const double turns = static_cast<double>(i) / kParticlesOfRing;
      particles[static_cast<size_t>(ring) * kParticlesOfRing + static_cast<size_t>(i)] =
          center + (u * cosineOfTurns(turns) + v * sineOfTurns(turns)) * radius;
    }
  }
  return particles;
}

class FlowField : public SynthField {
 public:
  explicit FlowField(const SynthOptions& options)
      : SynthField(options.dims), dims_(toDouble(options.dims)) {
    auto particles = startingParticles(options.seed);
    steps_.resize(static_cast<size_t>(options.time_steps));
    for (Step& step : steps_) {
      for (size_t i = 0; i < kParticles; ++i) {
        for (int a = 0; a < 3; ++a)
          step.particles[i][a] = static_cast<float>(wrapped(particles[i][a]));
        addToSlices(step, i);
        particles[i] = advanced(particles[i]);
      }
    }
  }

  bool fillRow(int64_t time, int64_t y, int64_t z, int64_t x0,
               std::span<float> row) const override {
    const double py = (static_cast<double>(y) + 0.5) / dims_.y;
    const double pz = (static_cast<double>(z) + 0.5) / dims_.z;
    const Step& step = steps_[static_cast<size_t>(time)];
    bool any = false;
    for (const uint16_t index : step.reaching[static_cast<size_t>(pz * kSlices)]) {
      const Vec3<float>& particle = step.particles[index];
      const double dy = nearest(py - static_cast<double>(particle.y));
      const double dz = nearest(pz - static_cast<double>(particle.z));
      const double rest = dy * dy + dz * dz;
      if (rest >= kReach * kReach) continue;
      for (const double image : {-1.0, 0.0, 1.0})
        addParticle(static_cast<double>(particle.x) + image, rest, x0, row, any);
    }
    if (any)
      for (float& value : row) value = std::min(value, 1.0F);
    return any;
  }

 private:
  static void addToSlices(Step& step, size_t i) {
    const auto z = static_cast<double>(step.particles[i].z);
    for (int slice = 0; slice < kSlices; ++slice) {
      const double middle = (slice + 0.5) / kSlices;
      if (std::abs(nearest(middle - z)) < kReach + 0.5 / kSlices + 1e-6)
        step.reaching[static_cast<size_t>(slice)].push_back(static_cast<uint16_t>(i));
    }
  }

  // The distance to the nearest of the periodic images.
  static double nearest(double d) { return d > 0.5 ? d - 1 : d < -0.5 ? d + 1 : d; }

  void addParticle(double center, double rest, int64_t x0, std::span<float> row, bool& any) const {
    const double half = std::sqrt(kReach * kReach - rest);
    const int64_t end = x0 + static_cast<int64_t>(row.size());
    const auto voxelAt = [&](double x) {
      return static_cast<int64_t>(std::ceil(x * dims_.x - 0.5));
    };
    const int64_t lo = std::max(voxelAt(center - half), x0);
    const int64_t hi = std::min(voxelAt(center + half), end);
    if (lo >= hi) return;
    if (!any) std::fill(row.begin(), row.end(), 0.0F);
    any = true;
    for (int64_t x = lo; x < hi; ++x) {
      const double dx = (static_cast<double>(x) + 0.5) / dims_.x - center;
      const double falloff = std::max(0.0, 1 - (dx * dx + rest) / (kReach * kReach));
      row[static_cast<size_t>(x - x0)] += static_cast<float>(kStrength * falloff * falloff);
    }
  }

  const Vec3d dims_;
  std::vector<Step> steps_;  // constant after construction
};

}  // namespace

std::unique_ptr<SynthField> makeFlowField(const SynthOptions& options) {
  return std::make_unique<FlowField>(options);
}

}  // namespace sluice
