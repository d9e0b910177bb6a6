// BrickRanges: the least and the greatest value of bricks of cells, in a grid that follows from the
// volume's size alone. Results that depend on them, such as the view that fits the visible part,
// are the same for any size of block, lit or not.
//
// A brick has as few cells a side as kMostRangeBricks allow: a volume of 64 voxels a side has a
// brick a cell, one of 1024 voxels bricks of 16 cells. Immutable once built.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/sources/voxel_taker.h"
#include "src/base/threads/mutex.h"
#include "src/volume/ranges/block_ranges.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// 512 KiB of u8, 2 MiB of f32.
inline constexpr int64_t kMostRangeBricks = int64_t{1} << 18;

struct BrickRanges {
  Box3 cells;        // cells of the volume that bricks cover; beyond them all is background
  int64_t side = 1;  // cells of a brick, fewer at the upper end of `cells`
  // PlaneRange<T> of each brick, x fastest: of every voxel around its cells, the border included.
  // Voxels that the source does not store count as its background. NaN does not count; lo > hi:
  // nothing else is there.
  std::vector<std::byte> ranges;

  Vec3i grid() const { return (cells.size() + Vec3i{side - 1, side - 1, side - 1}) / side; }
  Box3 cellsOf(Vec3i brick) const {
    const Vec3i lo = cells.lo + brick * side;
    return {lo, min(lo + Vec3i{side, side, side}, cells.hi)};
  }
  uint64_t bytes() const { return ranges.size(); }
  template <class T>
  std::span<const PlaneRange<T>> rangesAs() const {
    return {reinterpret_cast<const PlaneRange<T>*>(ranges.data()),
            ranges.size() / sizeof(PlaneRange<T>)};
  }
};

// The cells of a volume of `dims` voxels that bricks cover: all of them, so that a file that leaves
// out empty chunks gives the same view as one that stores them. Of a sparse volume with more voxels
// than any file stores, those between the first and the last that may differ from its background.
Box3 brickCells(Vec3i dims, const std::optional<Occupancy>& occupancy);
// The grid over these cells, without ranges. Without cells there are no bricks.
BrickRanges brickGrid(const Box3& cells, int64_t most_bricks = kMostRangeBricks);

// The same pass over the voxels as the other buildSliceRanges(), and the bricks from it. `taker`,
// if there is one, gets all voxels that are read; the pieces are then cut as it wants them, so that
// the pass's memory should have room for a piece of its side() cubed a thread.
SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             const VolumePass& pass, BrickRanges& bricks,
                             VoxelTaker* taker = nullptr);

// Whether each brick of `grid`, x fastest, has a cell of a block that is not among `blocks`.
// Requires: `blocks` is in ascending order without repeats.
std::vector<bool> reachesBeyond(const BrickRanges& grid, const BlockLayout& layout,
                                std::span<const int64_t> blocks);

// Fills a grid box by box, from any thread.
template <class T>
class BrickRangesBuilder {
 public:
  explicit BrickRangesBuilder(BrickRanges grid) : grid_(std::move(grid)) {
    result_.resize(static_cast<size_t>(volume(grid_.grid())), kNoVoxels<T>);
  }

  // `background`: the device value of all voxels of the blocks that are not among `blocks`. Bricks
  // without a cell of such a block get the range of their voxels alone.
  void addBackground(double background, const BlockLayout& layout, std::span<const int64_t> blocks)
      SLUICE_EXCLUDES(mutex_) {
    const std::vector<bool> has_background = reachesBeyond(grid_, layout, blocks);
    const MutexLock lock(mutex_);
    for (size_t i = 0; i < result_.size(); ++i)
      if (has_background[i])
        widen(result_[i], {lowOf(static_cast<T>(background)), static_cast<T>(background)});
  }

  // The voxels of `box`, x fastest and packed. Boxes may overlap.
  void add(const T* voxels, const Box3& box) SLUICE_EXCLUDES(mutex_) { add(voxels, voxels, box); }

  // The same for voxels that each have a range of values.
  void add(const T* least, const T* greatest, const Box3& box) SLUICE_EXCLUDES(mutex_) {
    // The cells that have one of the voxels at a corner.
    const Box3 cells = intersect({box.lo - Vec3i{1, 1, 1}, box.hi}, grid_.cells);
    if (cells.empty()) return;
    const Vec3i first = (cells.lo - grid_.cells.lo) / grid_.side;
    const Vec3i last = (cells.hi - Vec3i{1, 1, 1} - grid_.cells.lo) / grid_.side;
    const auto in_row = static_cast<size_t>(last.x - first.x + 1);
    // A layer at a time is short enough to be kept in memory that is there.
    std::vector<PlaneRange<T>> layer(in_row * static_cast<size_t>(last.y - first.y + 1));
    std::vector<T> lo(static_cast<size_t>(box.size().x)), hi(lo.size());
    for (int64_t z = first.z; z <= last.z; ++z) {
      PlaneRange<T>* found = layer.data();
      for (int64_t y = first.y; y <= last.y; ++y) {
        const Box3 row = unite(grid_.cellsOf({first.x, y, z}), grid_.cellsOf({last.x, y, z}));
        takeColumns(least, greatest, box, row, lo, hi);
        for (int64_t x = first.x; x <= last.x; ++x) {
          const int64_t from = grid_.cells.lo.x + x * grid_.side;
          const int64_t to = std::min(from + grid_.side, grid_.cells.hi.x) + 1;  // a voxel more
          *found++ = reduce(lo, hi, std::max(from, box.lo.x) - box.lo.x,
                            std::min(to, box.hi.x) - box.lo.x);
        }
      }
      merge(layer.data(), in_row, {first.x, first.y, z}, last.y);
    }
  }

  // To be called after the last add().
  BrickRanges finish() SLUICE_EXCLUDES(mutex_) {
    const MutexLock lock(mutex_);
    const auto bytes = std::as_bytes(std::span(result_));
    grid_.ranges.assign(bytes.begin(), bytes.end());
    return std::move(grid_);
  }

 private:
  // kNotANumber is below all values, so that it raises no maximum that a value has set.
  static T lowOf(T v) {
    if constexpr (std::is_same_v<T, float>)
      if (v == kNotANumber) return kNoVoxels<T>.lo;
    return v;
  }

  static Box3 voxelsOf(const Box3& cells) { return {cells.lo, cells.hi + Vec3i{1, 1, 1}}; }

  // The columns of a box's voxels around a row of bricks, element by element as vector units like
  // it.
  static void takeColumns(const T* least, const T* greatest, const Box3& box, const Box3& cells,
                          std::vector<T>& lo, std::vector<T>& hi) {
    const Vec3i size = box.size();
    std::fill(lo.begin(), lo.end(), kNoVoxels<T>.lo);
    std::fill(hi.begin(), hi.end(), kNoVoxels<T>.hi);
    T* __restrict low = lo.data();
    T* __restrict high = hi.data();
    const Box3 around = intersect(voxelsOf(cells), box);
    for (int64_t z = around.lo.z; z < around.hi.z; ++z)
      for (int64_t y = around.lo.y; y < around.hi.y; ++y) {
        const int64_t at = ((z - box.lo.z) * size.y + (y - box.lo.y)) * size.x;
        const T* row_least = least + at;
        const T* row_greatest = greatest + at;
        for (int64_t x = 0; x < size.x; ++x) {
          low[x] = std::min(low[x], lowOf(row_least[x]));
          high[x] = std::max(high[x], row_greatest[x]);
        }
      }
  }

  // The range of columns `from` to `to`, without the last.
  static PlaneRange<T> reduce(const std::vector<T>& lo, const std::vector<T>& hi, int64_t from,
                              int64_t to) {
    PlaneRange<T> range = kNoVoxels<T>;
    for (int64_t x = from; x < to; ++x)
      widen(range, {lo[static_cast<size_t>(x)], hi[static_cast<size_t>(x)]});
    return range;
  }

  // Rows of bricks from `first` on, the last of which is `last_y`.
  void merge(const PlaneRange<T>* found, size_t in_row, Vec3i first, int64_t last_y)
      SLUICE_EXCLUDES(mutex_) {
    const Vec3i grid = grid_.grid();
    const MutexLock lock(mutex_);
    for (int64_t y = first.y; y <= last_y; ++y) {
      PlaneRange<T>* to = &result_[static_cast<size_t>((first.z * grid.y + y) * grid.x + first.x)];
      for (size_t i = 0; i < in_row; ++i) widen(to[i], *found++);
    }
  }

  BrickRanges grid_;  // constant but for finish()
  Mutex mutex_;
  std::vector<PlaneRange<T>> result_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
