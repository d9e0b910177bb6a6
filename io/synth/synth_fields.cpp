// The texture and the kinds that are a few lines each.
#include "io/synth/synth_fields.h"

#include <algorithm>
#include <cmath>

#include "io/synth/synth_math.h"

namespace sluice {
namespace {

constexpr int64_t kTile = 64;

// value + neighbours on one axis of the repeating tile, weights 1 2 1.
void smooth(std::vector<float>& values, int64_t stride) {
  const std::vector<float> before = values;
  const int64_t extent = stride * kTile;
  for (int64_t i = 0; i < static_cast<int64_t>(values.size()); ++i) {
    const int64_t base = i / extent * extent, offset = i % extent;
    const auto at = [&](int64_t o) {
      return before[static_cast<size_t>(base + (o + extent) % extent)];
    };
    values[static_cast<size_t>(i)] =
        0.25F * at(offset - stride) + 0.5F * at(offset) + 0.25F * at(offset + stride);
  }
}

}  // namespace

TextureTile::TextureTile(uint64_t seed) : values_(static_cast<size_t>(kTile * kTile * kTile)) {
  for (size_t i = 0; i < values_.size(); ++i)
    values_[i] = static_cast<float>(2 * unitFrom(hash64(hash64(seed) ^ i)) - 1);
  for (const int64_t stride : {int64_t{1}, kTile, kTile * kTile}) smooth(values_, stride);
  // Smoothing shrinks the values; the largest is 1 again.
  float largest = 0;
  for (const float value : values_) largest = std::max(largest, std::abs(value));
  for (float& value : values_) value /= largest;
}

void TextureTile::add(std::span<float> row, int64_t x0, int64_t y, int64_t z,
                      float amplitude) const {
  const float* texture = values_.data() + ((z & (kTile - 1)) * kTile + (y & (kTile - 1))) * kTile;
  const auto count = static_cast<int64_t>(row.size());
  for (int64_t i = 0; i < count;) {
    const int64_t from = (x0 + i) & (kTile - 1);
    const int64_t n = std::min(kTile - from, count - i);
    float* to = row.data() + i;
    const float* add = texture + from;
    for (int64_t k = 0; k < n; ++k) to[k] += amplitude * add[k];
    i += n;
  }
}

namespace {

class ShellsField : public SynthField {
 public:
  explicit ShellsField(const SynthOptions& options)
      : SynthField(options.dims), center_(toDouble(options.dims - Vec3i{1, 1, 1}) / 2.0) {
    const double radius =
        static_cast<double>(std::min({options.dims.x, options.dims.y, options.dims.z})) / 2;
    square_ = radius * radius;
    per_square_ = kEntries / square_;
    for (int i = 0; i < kEntries; ++i) {
      const double r = std::sqrt((i + 0.5) / kEntries);  // 0..1
      for (int shell = 1; shell <= kShells; ++shell) {
        const double wall = 1 - std::abs(r - shell * 0.9 / kShells) / kHalfWall;
        if (wall > 0)
          table_[static_cast<size_t>(i)] = static_cast<float>(wall * (0.3 + 0.7 * shell / kShells));
      }
    }
  }

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    const double dy = static_cast<double>(y) - center_.y, dz = static_cast<double>(z) - center_.z;
    const double rest = dy * dy + dz * dz;
    if (rest >= square_) return false;
    for (size_t i = 0; i < row.size(); ++i) {
      const double dx = static_cast<double>(x0 + static_cast<int64_t>(i)) - center_.x;
      const double at = (dx * dx + rest) * per_square_;
      row[i] = table_[static_cast<size_t>(std::min(at, static_cast<double>(kEntries)))];
    }
    return true;
  }

 private:
  static constexpr int kShells = 5;
  static constexpr double kHalfWall = 0.05;  // share of the radius
  static constexpr int kEntries = 16384;
  const Vec3d center_;
  double square_ = 0, per_square_ = 0;
  // Value by the square of the distance; the last entry is 0.
  std::vector<float> table_ = std::vector<float>(kEntries + 1);
};

// S. Marschner, R. Lobb, An evaluation of reconstruction filters for volume rendering, 1994.
class MarschnerLobbField : public SynthField {
 public:
  explicit MarschnerLobbField(const SynthOptions& options)
      : SynthField(options.dims), dims_(options.dims) {}

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    constexpr double kFrequency = 6, kAlpha = 0.25;
    const double base = 1 - sineOfTurns(coordinate(2, z) / 4);  // sin(pi z / 2)
    const double cy = coordinate(1, y);
    for (size_t i = 0; i < row.size(); ++i) {
      const double cx = coordinate(0, x0 + static_cast<int64_t>(i));
      const double r = std::sqrt(cx * cx + cy * cy);
      const double ripple = cosineOfTurns(kFrequency * cosineOfTurns(r / 4));
      row[i] = static_cast<float>((base + kAlpha * (1 + ripple)) / (2 * (1 + kAlpha)));
    }
    return true;
  }

 private:
  // -1 at the first voxel, 1 at the last, as the paper samples it.
  double coordinate(int axis, int64_t i) const {
    return dims_[axis] == 1 ? 0
                            : 2 * static_cast<double>(i) / static_cast<double>(dims_[axis] - 1) - 1;
  }
  const Vec3i dims_;
};

// Balls in the bricks of a grid that a hash of the brick's position picks.
class SparseField : public SynthField {
 public:
  explicit SparseField(const SynthOptions& options)
      : SynthField(options.dims),
        seed_(hash64(options.seed)),
        chance_(chanceOf(options.object_share / kBallShare, options.dims)) {}

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    constexpr double kCenter = (kBrick - 1) / 2.0, kSquare = kRadius * kRadius;
    const double dy = static_cast<double>(y % kBrick) - kCenter;
    const double dz = static_cast<double>(z % kBrick) - kCenter;
    const double rest = dy * dy + dz * dz;
    if (rest >= kSquare) return false;
    const int64_t end = x0 + static_cast<int64_t>(row.size());
    bool any = false;
    for (int64_t brick = x0 / kBrick; brick * kBrick < end; ++brick) {
      if (lotOf({brick, y / kBrick, z / kBrick}) >= chance_) continue;
      if (!any) std::fill(row.begin(), row.end(), 0.0F);
      any = true;
      const int64_t lo = std::max(brick * kBrick, x0), hi = std::min((brick + 1) * kBrick, end);
      for (int64_t x = lo; x < hi; ++x) {
        const double dx = static_cast<double>(x - brick * kBrick) - kCenter;
        const double square = dx * dx + rest;
        if (square < kSquare)
          row[static_cast<size_t>(x - x0)] = static_cast<float>(1 - 0.8 * square / kSquare);
      }
    }
    return any;
  }

 private:
  static constexpr int64_t kBrick = 32;
  static constexpr double kRadius = 15.5;
  static constexpr double kBallShare = 15408.0 / (kBrick * kBrick * kBrick);  // voxels counted

  // The brick's lot, from 0 to 1: those with the lowest have balls.
  double lotOf(Vec3i brick) const { return unitFrom(hash64(seed_, brick.x, brick.y, brick.z)); }
  // The chance, or, in a volume so small that no brick might have a ball, as much as gives one.
  double chanceOf(double chance, Vec3i dims) const {
    const auto centers = [](int64_t voxels) {
      return std::max<int64_t>(1, (voxels + kBrick / 2) / kBrick);
    };
    const Vec3i bricks{centers(dims.x), centers(dims.y), centers(dims.z)};
    constexpr double kManyBalls = 64;
    if (static_cast<double>(volume(bricks)) * chance > kManyBalls) return chance;
    double least = 1;
    for (int64_t z = 0; z < bricks.z; ++z)
      for (int64_t y = 0; y < bricks.y; ++y)
        for (int64_t x = 0; x < bricks.x; ++x) least = std::min(least, lotOf({x, y, z}));
    return std::max(chance, std::nextafter(least, 1.0));
  }

  const uint64_t seed_;
  const double chance_;
};

class SlabField : public SynthField {
 public:
  explicit SlabField(const SynthOptions& options)
      : SynthField(options.dims), box_(boxOf(options.dims)), texture_(options.seed) {
    const int64_t planes = std::llround(options.object_share * static_cast<double>(options.dims.z));
    box_.lo.z = (options.dims.z - planes) / 2;
    box_.hi.z = box_.lo.z + planes;
  }

  bool fillRow(int64_t, int64_t y, int64_t z, int64_t x0, std::span<float> row) const override {
    if (z < box_.lo.z || z >= box_.hi.z) return false;
    std::fill(row.begin(), row.end(), 0.6F);
    texture_.add(row, x0, y, z, 0.3F);
    return true;
  }
  Box3 objectBox() const override { return box_; }

 private:
  Box3 box_;
  const TextureTile texture_;
};

class CubeField : public SynthField {
 public:
  explicit CubeField(const SynthOptions& options) : SynthField(options.dims) {}
  bool fillRow(int64_t, int64_t, int64_t, int64_t, std::span<float> row) const override {
    std::fill(row.begin(), row.end(), 0.5F);
    return true;
  }
};

}  // namespace

std::unique_ptr<SynthField> makeShellsField(const SynthOptions& options) {
  return std::make_unique<ShellsField>(options);
}
std::unique_ptr<SynthField> makeMarschnerLobbField(const SynthOptions& options) {
  return std::make_unique<MarschnerLobbField>(options);
}
std::unique_ptr<SynthField> makeSparseField(const SynthOptions& options) {
  return std::make_unique<SparseField>(options);
}
std::unique_ptr<SynthField> makeSlabField(const SynthOptions& options) {
  return std::make_unique<SlabField>(options);
}
std::unique_ptr<SynthField> makeCubeField(const SynthOptions& options) {
  return std::make_unique<CubeField>(options);
}

}  // namespace sluice
