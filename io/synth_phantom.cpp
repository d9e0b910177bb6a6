// The Shepp-Logan head in three dimensions. Ellipsoids: A. C. Kak, M. Slaney, Principles of
// Computerized Tomographic Imaging, 1988, p. 102. Densities: the variant of H. Yu, Y. Ye, G. Wang,
// Katsevich-type algorithms for variable radius spiral cone-beam CT, Proc. SPIE 5535, 2004, whose
// contrast shows on a screen.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/synth_fields.h"
#include "io/synth_math.h"

namespace sluice {
namespace {

struct Ellipsoid {
  double a, b, c;  // half axes
  double x, y, z;  // centre; the volume is [-1, 1]^3
  double turns;    // about z, counterclockwise
  double density;  // adds to what is there
};
constexpr std::array<Ellipsoid, 10> kHead = {{
    {0.6900, 0.920, 0.900, 0.00, 0.000, 0.000, 0.0, 1.0},
    {0.6624, 0.874, 0.880, 0.00, 0.000, 0.000, 0.0, -0.8},
    {0.4100, 0.160, 0.210, -0.22, 0.000, -0.250, 0.3, -0.2},
    {0.3100, 0.110, 0.220, 0.22, 0.000, -0.250, 0.2, -0.2},
    {0.2100, 0.250, 0.500, 0.00, 0.350, -0.250, 0.0, 0.2},
    {0.0460, 0.046, 0.046, 0.00, 0.100, -0.250, 0.0, 0.2},
    {0.0460, 0.023, 0.020, -0.08, -0.650, -0.250, 0.0, 0.1},
    {0.0460, 0.023, 0.020, 0.06, -0.650, -0.250, 0.25, 0.1},
    {0.0560, 0.040, 0.100, 0.06, -0.105, 0.625, 0.25, 0.2},
    {0.0560, 0.056, 0.100, 0.00, 0.100, 0.625, 0.0, -0.2},
}};
constexpr double kScale = 0.9;        // leaves room for the texture above bone
constexpr float kTexture = 0.03F;     // amplitude
constexpr double kAirDensity = 0.01;  // below this is air: exactly 0, no texture

// A half-open run of voxels along x inside one ellipsoid.
struct Run {
  int64_t lo, hi;
  double density;
};

class PhantomField : public SynthField {
 public:
  explicit PhantomField(const SynthOptions& options)
      : SynthField(options.dims), dims_(options.dims), texture_(options.seed) {
    for (size_t i = 0; i < kHead.size(); ++i) {
      cosine_[i] = cosineOfTurns(kHead[i].turns);
      sine_[i] = sineOfTurns(kHead[i].turns);
    }
  }

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    const int64_t end = x0 + static_cast<int64_t>(row.size());
    std::array<Run, kHead.size()> runs;
    std::array<int64_t, 2 * kHead.size() + 2> edges{x0, end};
    size_t run_count = 0, edge_count = 2;
    for (size_t i = 0; i < kHead.size(); ++i) {
      const Run run = runOf(i, y, z);
      if (run.lo >= end || run.hi <= x0 || run.lo >= run.hi) {
        if (i == 0) return false;  // all others lie inside the first
        continue;
      }
      runs[run_count++] = run;
      edges[edge_count++] = std::max(run.lo, x0);
      edges[edge_count++] = std::min(run.hi, end);
    }
    std::sort(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(edge_count));
    bool any = false;
    for (size_t e = 0; e + 1 < edge_count; ++e) {
      const int64_t lo = edges[e], hi = edges[e + 1];
      if (lo == hi) continue;
      double density = 0;
      for (size_t r = 0; r < run_count; ++r)
        if (runs[r].lo <= lo && lo < runs[r].hi) density += runs[r].density;
      const auto part = row.subspan(static_cast<size_t>(lo - x0), static_cast<size_t>(hi - lo));
      if (density < kAirDensity) {
        std::fill(part.begin(), part.end(), 0.0F);
      } else {
        std::fill(part.begin(), part.end(), static_cast<float>(density * kScale));
        texture_.add(part, lo, y, z, kTexture);
        any = true;
      }
    }
    return any;
  }

 private:
  // The voxel's centre on one axis, -1..1.
  double coordinate(int axis, int64_t i) const {
    return static_cast<double>(2 * i + 1) / static_cast<double>(dims_[axis]) - 1;
  }

  // Where row (y, z) is inside ellipsoid i, in voxels of the whole row, so that it does not depend
  // on the box that is read.
  Run runOf(size_t i, int64_t y, int64_t z) const {
    const Ellipsoid& e = kHead[i];
    const double dy = coordinate(1, y) - e.y, dz = (coordinate(2, z) - e.z) / e.c;
    const double rest = 1 - dz * dz;
    if (rest <= 0) return {0, 0, 0};
    // ((cos dx + sin dy) / a)^2 + ((cos dy - sin dx) / b)^2 <= rest, a quadratic in dx.
    const double p = cosine_[i] / e.a, q = -sine_[i] / e.b;
    const double r = sine_[i] * dy / e.a, s = cosine_[i] * dy / e.b;
    const double square = p * p + q * q, half_linear = p * r + q * s;
    const double discriminant = half_linear * half_linear - square * (r * r + s * s - rest);
    if (discriminant <= 0) return {0, 0, 0};
    const double root = std::sqrt(discriminant);
    return {firstVoxelAt(e.x + (-half_linear - root) / square),
            firstVoxelAt(e.x + (-half_linear + root) / square), e.density};
  }

  // The first voxel whose centre is at or beyond x in -1..1.
  int64_t firstVoxelAt(double x) const {
    return static_cast<int64_t>(std::ceil((x + 1) * static_cast<double>(dims_.x) / 2 - 0.5));
  }

  const Vec3i dims_;
  const TextureTile texture_;
  std::array<double, kHead.size()> cosine_{}, sine_{};  // constant after construction
};

}  // namespace

std::unique_ptr<SynthField> makePhantomField(const SynthOptions& options) {
  return std::make_unique<PhantomField>(options);
}

}  // namespace sluice
