#include "src/classify/boxes/brick_grid.h"

#include <array>
#include <cmath>
#include <limits>

#include "src/base/error.h"

namespace sluice {
namespace {

// The quantities that are reduced over the voxels of a brick.
enum Channel { kValue, kX, kY, kZ, kSquare, kChannels };

// Least and greatest of each channel, one element a voxel of a row: columns of rows are reduced
// element by element, which compilers turn into vector code, and x comes last.
class Reduction {
 public:
  explicit Reduction(size_t count) : count_(count), lo_(kChannels * count), hi_(lo_.size()) {
    reset();
  }
  void reset() {
    std::fill(lo_.begin(), lo_.end(), std::numeric_limits<float>::max());
    std::fill(hi_.begin(), hi_.end(), std::numeric_limits<float>::lowest());
  }
  void widen(size_t channel, const float* __restrict row) {
    float* __restrict lo = lo_.data() + channel * count_;
    float* __restrict hi = hi_.data() + channel * count_;
    for (size_t i = 0; i < count_; ++i) {
      lo[i] = row[i] < lo[i] ? row[i] : lo[i];
      hi[i] = row[i] > hi[i] ? row[i] : hi[i];
    }
  }
  void widen(const Reduction& by) {
    float* __restrict lo = lo_.data();
    float* __restrict hi = hi_.data();
    const float* __restrict by_lo = by.lo_.data();
    const float* __restrict by_hi = by.hi_.data();
    for (size_t i = 0; i < lo_.size(); ++i) {
      lo[i] = by_lo[i] < lo[i] ? by_lo[i] : lo[i];
      hi[i] = by_hi[i] > hi[i] ? by_hi[i] : hi[i];
    }
  }
  // The range over voxels [from, to] of the row.
  CellRange range(size_t from, size_t to) const {
    std::array<float, kChannels> lo{}, hi{};
    for (size_t c = 0; c < kChannels; ++c) {
      // Columns up to `to` included: the voxels on both faces of a brick are its own.
      lo[c] = *std::min_element(&lo_[c * count_ + from], &lo_[c * count_ + to] + 1);
      hi[c] = *std::max_element(&hi_[c * count_ + from], &hi_[c * count_ + to] + 1);
    }
    // Interpolated gradients of two directions may cancel: the least magnitude is the distance of
    // the box of the components from zero. The greatest is a corner's, since lengths are convex.
    float nearest = 0;
    for (size_t c = kX; c <= kZ; ++c) {
      const float away = std::max({lo[c], -hi[c], 0.F});
      nearest += away * away;
    }
    return {lo[kValue], hi[kValue], std::min(std::sqrt(nearest), kLargest),
            std::min(std::sqrt(hi[kSquare]), kLargest)};
  }

 private:
  size_t count_;
  std::vector<float> lo_, hi_;
};

template <class T>
class Builder {
 public:
  Builder(const VoxelSpan& voxels, const Box3& cells, Vec3d voxel_size, BrickGrid& grid)
      : first_(reinterpret_cast<const T*>(voxels.bytes)),
        held_(voxels.voxels),
        corners_{cells.lo, cells.hi + Vec3i{1, 1, 1}},
        grid_(grid),
        row_(static_cast<size_t>(corners_.size().x)) {
    for (int a = 0; a < 3; ++a) per_difference_[a] = static_cast<float>(0.5 / voxel_size[a]);
    for (auto& channel : scratch_) channel.resize(row_);
  }

  void build() {
    const auto rows = static_cast<size_t>(grid_.size.y);
    std::vector<Reduction> plane(rows, Reduction(row_)), slab(rows, Reduction(row_));
    for (int64_t z = 0; z < corners_.size().z; ++z) {
      for (Reduction& reduction : plane) reduction.reset();
      for (int64_t y = 0; y < corners_.size().y; ++y) {
        fillRow(y, z);
        forBricks(y, grid_.size.y, [&](int64_t brick) {
          for (size_t c = 0; c < kChannels; ++c)
            plane[static_cast<size_t>(brick)].widen(c, scratch_[c].data());
        });
      }
      for (size_t i = 0; i < rows; ++i) slab[i].widen(plane[i]);
      // A plane between two bricks ends one and begins the other.
      const bool ends = z > 0 && (z % grid_.side == 0 || z + 1 == corners_.size().z);
      if (!ends) continue;
      finishSlab(slab);
      slab = plane;
    }
  }

 private:
  // The bricks that voxel plane `at` belongs to: two if it lies between them.
  template <class F>
  void forBricks(int64_t at, int64_t count, F&& f) const {
    const int64_t brick = at / grid_.side;
    if (brick < count) f(brick);
    if (brick > 0 && at % grid_.side == 0) f(brick - 1);
  }

  const T* rowAt(int64_t y, int64_t z) const {
    const Vec3i size = held_.size();
    // Beyond the voxels that are held, the last one repeats, as at the border of the volume.
    y = std::clamp(y, held_.lo.y, held_.hi.y - 1) - held_.lo.y;
    z = std::clamp(z, held_.lo.z, held_.hi.z - 1) - held_.lo.z;
    return first_ + (z * size.y + y) * size.x;
  }

  void fillRow(int64_t y, int64_t z) {
    y += corners_.lo.y;
    z += corners_.lo.z;
    const int64_t from = corners_.lo.x - held_.lo.x;
    const T* here = rowAt(y, z);
    difference(kY, rowAt(y + 1, z) + from, rowAt(y - 1, z) + from);
    difference(kZ, rowAt(y, z + 1) + from, rowAt(y, z - 1) + from);
    float* value = scratch_[kValue].data();
    for (size_t i = 0; i < row_; ++i)
      value[i] = static_cast<float>(here[from + static_cast<int64_t>(i)]);
    float* x = scratch_[kX].data();
    // The ends are computed apart, so that this loop has no branches.
    for (size_t i = 1; i + 1 < row_; ++i) x[i] = (value[i + 1] - value[i - 1]) * per_difference_[0];
    const auto endAt = [&](size_t i) {
      const int64_t at = from + static_cast<int64_t>(i);
      const int64_t up = std::min(at + 1, held_.size().x - 1), down = std::max<int64_t>(at - 1, 0);
      x[i] = (static_cast<float>(here[up]) - static_cast<float>(here[down])) * per_difference_[0];
    };
    endAt(0);
    endAt(row_ - 1);
    float* __restrict square = scratch_[kSquare].data();
    const float* __restrict dy = scratch_[kY].data();
    const float* __restrict dz = scratch_[kZ].data();
    for (size_t i = 0; i < row_; ++i) square[i] = x[i] * x[i] + dy[i] * dy[i] + dz[i] * dz[i];
  }

  void difference(Channel channel, const T* __restrict up, const T* __restrict down) {
    float* __restrict to = scratch_[channel].data();
    const float scale = per_difference_[channel - kX];
    for (size_t i = 0; i < row_; ++i)
      to[i] = (static_cast<float>(up[i]) - static_cast<float>(down[i])) * scale;
  }

  void finishSlab(const std::vector<Reduction>& slab) {
    const auto side = static_cast<size_t>(grid_.side);
    for (const Reduction& reduction : slab)
      for (size_t x = 0; x < static_cast<size_t>(grid_.size.x); ++x)
        grid_.bricks.push_back(reduction.range(x * side, std::min((x + 1) * side, row_ - 1)));
  }

  const T* first_;
  const Box3 held_, corners_;
  BrickGrid& grid_;
  const size_t row_;  // corner voxels of a row
  std::array<float, 3> per_difference_{};
  std::array<std::vector<float>, kChannels> scratch_;  // for one row
};

}  // namespace

CellRange rangeOf(const BrickGrid& grid, const Box3& bricks) {
  CellRange range = grid.at(bricks.lo);
  for (int64_t z = bricks.lo.z; z < bricks.hi.z; ++z)
    for (int64_t y = bricks.lo.y; y < bricks.hi.y; ++y) {
      const CellRange* row = &grid.at({bricks.lo.x, y, z});
      for (int64_t x = 0; x < bricks.size().x; ++x) range = unite(range, row[x]);
    }
  return range;
}

BrickGrid brickGrid(const VoxelSpan& voxels, const Box3& cells, int64_t side, Vec3d voxel_size) {
  SLUICE_CHECK(!cells.empty() && side >= 1);
  SLUICE_CHECK(voxels.voxels.contains(Box3{cells.lo, cells.hi + Vec3i{1, 1, 1}}));
  const Vec3i size = cells.size();
  // Larger blocks get larger bricks, so that a tree keeps its greatest depth.
  while (ceilDiv(std::max({size.x, size.y, size.z}), side) > kMostBricks) side *= 2;
  BrickGrid grid{
      cells, side, {ceilDiv(size.x, side), ceilDiv(size.y, side), ceilDiv(size.z, side)}, {}};
  grid.bricks.reserve(static_cast<size_t>(volume(grid.size)));
  visitDeviceType(voxels.type, [&](auto tag) {
    Builder<decltype(tag)>(voxels, cells, voxel_size, grid).build();
  });
  return grid;
}

}  // namespace sluice
