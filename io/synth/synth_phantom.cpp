// The Shepp-Logan head in three dimensions. Ellipsoids: A. C. Kak, M. Slaney, Principles of
// Computerized Tomographic Imaging, 1988, p. 102. Densities: the variant of H. Yu, Y. Ye, G. Wang,
// Katsevich-type algorithms for variable radius spiral cone-beam CT, Proc. SPIE 5535, 2004, whose
// contrast shows on a screen.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/synth/synth_fields.h"
#include "io/synth/synth_math.h"

namespace sluice {
namespace {

struct Ellipsoid {
  double a, b, c;  // half axes
  double x, y, z;  // centre; the volume is [-1, 1]^3
  double turns;    // about z, counterclockwise
  double density;  // is added to the density so far
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
constexpr float kAirDensity = 0.01F;  // below this is air: exactly 0, no texture
// Half of the width of an edge in voxels, as a scanner blurs it. Interpolation and central
// differences make stairs of narrower ones, which light shows as rings. Volumes of few voxels have
// narrow edges all the same, so that the skull keeps its density.
constexpr double kEdgeVoxels = 2.25, kLeastEdgeVoxels = 0.5, kVoxelsOfWholeEdge = 256;

// A half-open run of voxels along x.
struct Run {
  int64_t lo = 0, hi = 0;
};

// The ellipsoids in a volume of these dimensions.
class HeadShapes {
 public:
  explicit HeadShapes(Vec3i dims) : dims_(dims) {
    for (size_t i = 0; i < kHead.size(); ++i) {
      cosine_[i] = cosineOfTurns(kHead[i].turns);
      sine_[i] = sineOfTurns(kHead[i].turns);
    }
  }

  // The part of row (y, z) inside ellipsoid i grown by `grown_vox` voxels, in voxels of the whole
  // row, so that it does not depend on the box that is read.
  Run runOf(size_t i, int64_t y, int64_t z, double grown_vox) const {
    const Ellipsoid& e = kHead[i];
    const double grown = grown_vox * std::max({voxelSize(0), voxelSize(1), voxelSize(2)});
    const double a = e.a + grown, b = e.b + grown, c = e.c + grown;
    if (std::min({a, b, c}) <= 0) return {};
    const double dy = coordinate(1, y) - e.y, dz = (coordinate(2, z) - e.z) / c;
    const double rest = 1 - dz * dz;
    if (rest <= 0) return {};
    // ((cos dx + sin dy) / a)^2 + ((cos dy - sin dx) / b)^2 <= rest, a quadratic in dx.
    const double p = cosine_[i] / a, q = -sine_[i] / b;
    const double r = sine_[i] * dy / a, s = cosine_[i] * dy / b;
    const double square = p * p + q * q, half_linear = p * r + q * s;
    const double discriminant = half_linear * half_linear - square * (r * r + s * s - rest);
    if (discriminant <= 0) return {};
    const double root = std::sqrt(discriminant);
    return {firstVoxelAt(e.x + (-half_linear - root) / square),
            firstVoxelAt(e.x + (-half_linear + root) / square)};
  }

  // The share of ellipsoid i in a voxel, from its distance to the surface: half at it, all or none
  // beyond an edge of twice `edge_vox`, and smooth in between.
  float coverage(size_t i, int64_t x, int64_t y, int64_t z, double edge_vox) const {
    const Ellipsoid& e = kHead[i];
    const double dx = coordinate(0, x) - e.x, dy = coordinate(1, y) - e.y;
    const double u = (cosine_[i] * dx + sine_[i] * dy) / e.a;
    const double v = (cosine_[i] * dy - sine_[i] * dx) / e.b;
    const double w = (coordinate(2, z) - e.z) / e.c;
    // The gradient of u^2 + v^2 + w^2, per voxel along each axis.
    const double gx = 2 * (u * cosine_[i] / e.a - v * sine_[i] / e.b) * voxelSize(0);
    const double gy = 2 * (u * sine_[i] / e.a + v * cosine_[i] / e.b) * voxelSize(1);
    const double gz = 2 * w / e.c * voxelSize(2);
    const double steepness = std::sqrt(gx * gx + gy * gy + gz * gz);
    const double inside = 1 - (u * u + v * v + w * w);
    if (steepness <= 0) return inside > 0 ? 1 : 0;
    const double share = std::clamp(0.5 + inside / steepness / (2 * edge_vox), 0.0, 1.0);
    return static_cast<float>(share * share * (3 - 2 * share));
  }

 private:
  // The voxel's centre on one axis, -1..1.
  double coordinate(int axis, int64_t i) const {
    return static_cast<double>(2 * i + 1) / static_cast<double>(dims_[axis]) - 1;
  }
  double voxelSize(int axis) const { return 2.0 / static_cast<double>(dims_[axis]); }

  // The first voxel whose centre is at or beyond x in -1..1.
  int64_t firstVoxelAt(double x) const {
    return static_cast<int64_t>(std::ceil((x + 1) * static_cast<double>(dims_.x) / 2 - 0.5));
  }

  const Vec3i dims_;
  std::array<double, kHead.size()> cosine_{}, sine_{};  // constant after construction
};

class PhantomField : public SynthField {
 public:
  explicit PhantomField(const SynthOptions& options)
      : SynthField(options.dims), shapes_(options.dims), texture_(options.seed) {
    const Vec3i dims = options.dims;
    const auto side = static_cast<double>(std::min({dims.x, dims.y, dims.z}));
    edge_vox_ = std::clamp(kEdgeVoxels * side / kVoxelsOfWholeEdge, kLeastEdgeVoxels, kEdgeVoxels);
  }

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    const Run whole{x0, x0 + static_cast<int64_t>(row.size())};
    const auto clipped = [&](Run run) {
      const int64_t lo = std::clamp(run.lo, whole.lo, whole.hi);
      return Run{lo, std::clamp(run.hi, lo, whole.hi)};
    };
    bool any = false;
    for (size_t i = 0; i < kHead.size(); ++i) {
      const Run outer = clipped(shapes_.runOf(i, y, z, edge_vox_ + 0.5));
      if (outer.lo == outer.hi) {
        if (i == 0) return false;  // all others lie inside the first
        continue;
      }
      if (!any) std::fill(row.begin(), row.end(), 0.0F);
      any = true;
      Run inner = clipped(shapes_.runOf(i, y, z, -edge_vox_ - 0.5));
      inner.lo = std::clamp(inner.lo, outer.lo, outer.hi);
      inner.hi = std::clamp(inner.hi, inner.lo, outer.hi);
      const auto density = static_cast<float>(kHead[i].density * kScale);
      for (int64_t x = outer.lo; x < inner.lo; ++x)
        row[static_cast<size_t>(x - x0)] += density * shapes_.coverage(i, x, y, z, edge_vox_);
      for (int64_t x = inner.lo; x < inner.hi; ++x) row[static_cast<size_t>(x - x0)] += density;
      for (int64_t x = inner.hi; x < outer.hi; ++x)
        row[static_cast<size_t>(x - x0)] += density * shapes_.coverage(i, x, y, z, edge_vox_);
    }
    return any && addTexture(y, z, x0, row);
  }

 private:
  // Air becomes exactly 0, everything else is textured. Returns whether anything is left.
  bool addTexture(int64_t y, int64_t z, int64_t x0, std::span<float> row) const {
    bool any = false;
    for (size_t lo = 0; lo < row.size();) {
      if (row[lo] < kAirDensity) {
        row[lo++] = 0;
        continue;
      }
      size_t hi = lo;
      while (hi < row.size() && row[hi] >= kAirDensity) ++hi;
      texture_.add(row.subspan(lo, hi - lo), x0 + static_cast<int64_t>(lo), y, z, kTexture);
      for (size_t i = lo; i < hi; ++i) row[i] = std::max(row[i], 0.0F);
      any = true;
      lo = hi;
    }
    return any;
  }

  const HeadShapes shapes_;
  const TextureTile texture_;
  double edge_vox_ = kEdgeVoxels;  // constant after construction
};

// Which of the ellipsoids a voxel's centre lies in: the last one that holds it, from 1 on.
class HeadParts : public SynthField {
 public:
  explicit HeadParts(const SynthOptions& options)
      : SynthField(options.dims),
        shapes_(options.dims),
        unit_(1.0F / (options.type == VoxelType::kU8 ? 255.0F : 65535.0F)) {}

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    const int64_t x1 = x0 + static_cast<int64_t>(row.size());
    bool any = false;
    for (size_t i = 0; i < kHead.size(); ++i) {
      const Run run = shapes_.runOf(i, y, z, 0);
      const int64_t lo = std::clamp(run.lo, x0, x1), hi = std::clamp(run.hi, lo, x1);
      if (lo == hi) continue;
      if (!any) std::fill(row.begin(), row.end(), 0.0F);
      any = true;
      std::fill(row.begin() + (lo - x0), row.begin() + (hi - x0),
                static_cast<float>(i + 1) * unit_);
    }
    return any;
  }

 private:
  const HeadShapes shapes_;
  const float unit_;  // of labels in 0..1
};

}  // namespace

std::unique_ptr<SynthField> makePhantomField(const SynthOptions& options) {
  return std::make_unique<PhantomField>(options);
}

std::unique_ptr<SynthField> makePartsField(const SynthOptions& options) {
  return std::make_unique<HeadParts>(options);
}

}  // namespace sluice
