#include "src/volume/slice_ranges.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>

#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/volume/key_histogram.h"

namespace sluice {
namespace {

// One read holds at most about this many voxels, so that a row of a very wide volume is cut.
constexpr int64_t kVoxelsPerRead = int64_t{16} << 20;

// A run of neighbouring blocks along x, read together.
struct Run {
  Vec3i first;  // block index
  int64_t count;
};

template <class T>
constexpr PlaneRange<T> kNothing{std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()};

template <class T>
void widen(PlaneRange<T>& range, PlaneRange<T> by) {
  range.lo = std::min(range.lo, by.lo);
  range.hi = std::max(range.hi, by.hi);
}

// Element-wise, so that the compiler makes vector code of it for every type.
template <class T>
void widenRow(T* __restrict lo, T* __restrict hi, const T* __restrict row, int64_t count) {
  for (int64_t i = 0; i < count; ++i) {
    lo[i] = row[i] < lo[i] ? row[i] : lo[i];
    hi[i] = row[i] > hi[i] ? row[i] : hi[i];
  }
}

template <class T>
PlaneRange<T> reduce(const T* lo, const T* hi, int64_t count) {
  PlaneRange<T> range = kNothing<T>;
  for (int64_t i = 0; i < count; ++i) widen(range, {lo[i], hi[i]});
  return range;
}

// Work space of one thread for one block.
template <class T>
struct Scratch {
  explicit Scratch(int64_t side)
      : z_lo(side), z_hi(side), x_lo(side), x_hi(side), y_lo(side * side), y_hi(side * side) {}
  std::vector<T> z_lo, z_hi, x_lo, x_hi, y_lo, y_hi;
};

// The arrays of one block from voxels laid out x fastest with the given strides. `out` is
// [3][side].
template <class T>
PlaneRange<T> rangesOfBlock(const T* voxels, Vec3i size, int64_t row_stride, int64_t plane_stride,
                            int64_t side, Scratch<T>& s, PlaneRange<T>* out) {
  const auto reset = [](std::vector<T>& lo, std::vector<T>& hi) {
    std::fill(lo.begin(), lo.end(), kNothing<T>.lo);
    std::fill(hi.begin(), hi.end(), kNothing<T>.hi);
  };
  std::fill(out, out + 3 * side, kNothing<T>);
  reset(s.x_lo, s.x_hi);
  reset(s.y_lo, s.y_hi);
  for (int64_t z = 0; z < size.z; ++z) {
    reset(s.z_lo, s.z_hi);
    for (int64_t y = 0; y < size.y; ++y) {
      const T* row = voxels + z * plane_stride + y * row_stride;
      widenRow(s.z_lo.data(), s.z_hi.data(), row, size.x);
      widenRow(s.y_lo.data() + y * side, s.y_hi.data() + y * side, row, size.x);
    }
    widenRow(s.x_lo.data(), s.x_hi.data(), s.z_lo.data(), size.x);
    widenRow(s.x_lo.data(), s.x_hi.data(), s.z_hi.data(), size.x);
    out[2 * side + z] = reduce(s.z_lo.data(), s.z_hi.data(), size.x);
  }
  for (int64_t y = 0; y < size.y; ++y)
    out[side + y] = reduce(s.y_lo.data() + y * side, s.y_hi.data() + y * side, size.x);
  PlaneRange<T> total = kNothing<T>;
  for (int64_t x = 0; x < size.x; ++x) {
    out[x] = {s.x_lo[static_cast<size_t>(x)], s.x_hi[static_cast<size_t>(x)]};
    widen(total, out[x]);
  }
  return total;
}

// The voxel planes between which the block's owned cells lie.
Box3 ownedVoxels(const BlockLayout& layout, Vec3i index) {
  const Box3 cells = layout.ownedCells(index);
  return {cells.lo, cells.hi + Vec3i{1, 1, 1}};
}

std::vector<Run> runsOfRow(const BlockLayout& layout, const std::vector<int64_t>& blocks) {
  const int64_t most =
      std::max<int64_t>(1, kVoxelsPerRead / volume(Vec3i{layout.size, layout.size, layout.size}));
  std::vector<Run> runs;
  for (const int64_t block : blocks) {
    const Vec3i index = layout.indexOf(block);
    const bool joins = !runs.empty() && runs.back().count < most &&
                       runs.back().first + Vec3i{runs.back().count, 0, 0} == index;
    if (joins) {
      ++runs.back().count;
    } else {
      runs.push_back({index, 1});
    }
  }
  return runs;
}

// Blocks that may hold something else than the background, ascending.
std::vector<int64_t> candidates(const BlockLayout& layout,
                                const std::optional<Occupancy>& occupancy) {
  std::vector<int64_t> blocks;
  if (!occupancy) {
    blocks.resize(static_cast<size_t>(layout.blockCount()));
    for (size_t i = 0; i < blocks.size(); ++i) blocks[i] = static_cast<int64_t>(i);
    return blocks;
  }
  for (const Box3& box : occupancy->boxes) {
    if (box.empty()) continue;
    // A voxel on a shared plane belongs to the blocks on both sides.
    Vec3i lo, hi;
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::max<int64_t>(0, (box.lo[a] - 1) / layout.cells());
      hi[a] = std::min(layout.grid[a] - 1, (box.hi[a] - 1) / layout.cells());
    }
    for (int64_t z = lo.z; z <= hi.z; ++z)
      for (int64_t y = lo.y; y <= hi.y; ++y)
        for (int64_t x = lo.x; x <= hi.x; ++x) blocks.push_back(layout.idOf({x, y, z}));
    // Leaves of sparse formats repeat blocks many times over.
    if (blocks.size() > (size_t{1} << 22)) {
      std::sort(blocks.begin(), blocks.end());
      blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    }
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

template <class T>
class Builder {
 public:
  Builder(VolumeSource& source, int64_t time, SliceRanges& result)
      : source_(source), time_(time), result_(result) {
    totals_.resize(result.blocks.size());
    planes_.resize(result.blocks.size() * 3 * static_cast<size_t>(result.layout.planes()));
  }

  void readRun(const Run& run) {
    const BlockLayout& layout = result_.layout;
    const Vec3i last = run.first + Vec3i{run.count - 1, 0, 0};
    const Box3 box = unite(ownedVoxels(layout, run.first), ownedVoxels(layout, last));
    const VoxelType stored_type = source_.layout().type;
    const auto count = static_cast<size_t>(box.count());
    // Uninitialised on purpose: every byte is overwritten by the read.
    const auto stored =
        std::make_unique_for_overwrite<std::byte[]>(count * bytesPerVoxel(stored_type));
    const std::span<std::byte> stored_bytes(stored.get(), count * bytesPerVoxel(stored_type));
    source_.readRegion(time_, box, stored_bytes);
    const auto device = std::make_unique_for_overwrite<T[]>(count);
    toDevice(stored_type, stored_bytes, std::as_writable_bytes(std::span(device.get(), count)));

    const Vec3i size = box.size();
    Scratch<T> scratch(layout.planes());
    const auto held = static_cast<size_t>(
        std::lower_bound(result_.blocks.begin(), result_.blocks.end(), layout.idOf(run.first)) -
        result_.blocks.begin());
    for (int64_t i = 0; i < run.count; ++i) {
      const Box3 voxels = ownedVoxels(layout, run.first + Vec3i{i, 0, 0});
      const size_t at = held + static_cast<size_t>(i);
      totals_[at] = rangesOfBlock(device.get() + (voxels.lo.x - box.lo.x), voxels.size(), size.x,
                                  size.x * size.y, layout.planes(), scratch,
                                  planes_.data() + at * 3 * static_cast<size_t>(layout.planes()));
    }
    KeyHistogram<T> histogram;
    for (int64_t z = 0; z < size.z; z += 2)
      for (int64_t y = 0; y < size.y; y += 2)
        histogram.add(device.get() + (z * size.y + y) * size.x, size.x);
    std::lock_guard lock(mutex_);
    histogram_.add(histogram);
  }

  void finish(std::optional<double> known_background) {
    result_.background = known_background
                             ? deviceFromStored(source_.layout().type, *known_background)
                             : mostCommonUniform();
    result_.device_range = range(known_background.has_value());
    histogram_.finish(result_.device_range, result_.histogram);
    keepOnlyNonBackground();
    const auto bytesOf = [](const auto& values) {
      const auto bytes = std::as_bytes(std::span(values));
      return std::vector<std::byte>(bytes.begin(), bytes.end());
    };
    result_.totals = bytesOf(totals_);
    result_.planes = bytesOf(planes_);
  }

 private:
  bool uniform(size_t held) const { return totals_[held].lo == totals_[held].hi; }

  double mostCommonUniform() const {
    std::map<T, int64_t> counts;
    for (size_t i = 0; i < totals_.size(); ++i)
      if (uniform(i)) ++counts[totals_[i].lo];
    int64_t most = 0;
    double value = 0;
    for (const auto& [candidate, count] : counts)
      if (count > most) {
        most = count;
        value = static_cast<double>(candidate);
      }
    return value;
  }

  ValueRange range(bool background_counts) const {
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    const auto take = [&](double v) {
      if (std::is_same_v<T, float> && (v <= kNotANumber || v >= kLargest)) return;
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    };
    if (background_counts) take(result_.background);
    for (size_t i = 0; i < totals_.size(); ++i) {
      take(totals_[i].lo);
      take(totals_[i].hi);
      // NaN hides the least real value of its block: look at the planes.
      if (std::is_same_v<T, float> && totals_[i].lo <= kNotANumber)
        for (const PlaneRange<T>& plane :
             std::span(planes_).subspan(i * 3 * static_cast<size_t>(result_.layout.planes()),
                                        3 * static_cast<size_t>(result_.layout.planes())))
          if (plane.lo <= plane.hi) take(plane.lo);
    }
    if (lo > hi) return {0, 0};
    return {lo, hi};
  }

  void keepOnlyNonBackground() {
    const auto per_block = static_cast<size_t>(3 * result_.layout.planes());
    size_t kept = 0;
    for (size_t i = 0; i < totals_.size(); ++i) {
      if (uniform(i) && static_cast<double>(totals_[i].lo) == result_.background) continue;
      if (kept != i) {
        totals_[kept] = totals_[i];
        result_.blocks[kept] = result_.blocks[i];
        std::copy_n(planes_.begin() + static_cast<ptrdiff_t>(i * per_block), per_block,
                    planes_.begin() + static_cast<ptrdiff_t>(kept * per_block));
      }
      ++kept;
    }
    totals_.resize(kept);
    planes_.resize(kept * per_block);
    result_.blocks.resize(kept);
    result_.blocks.shrink_to_fit();
  }

  VolumeSource& source_;
  const int64_t time_;
  SliceRanges& result_;
  // Each run writes its own elements.
  std::vector<PlaneRange<T>> totals_, planes_;
  std::mutex mutex_;
  KeyHistogram<T> histogram_;  // guarded by mutex_
};

}  // namespace

SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             WorkerPool& pool, Progress& progress) {
  SliceRanges result;
  result.layout = layout;
  result.map = deviceMap(source.layout());
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  result.blocks = candidates(layout, occupancy);
  // Rows of blocks, so that each read is long and memory stays bounded whatever the volume.
  std::vector<Run> runs = runsOfRow(layout, result.blocks);
  visitDeviceType(result.map.type, [&](auto tag) {
    Builder<decltype(tag)> builder(source, time, result);
    pool.parallelFor(static_cast<int64_t>(runs.size()), [&](int64_t i) {
      throwIfInterrupted();
      const Run& run = runs[static_cast<size_t>(i)];
      builder.readRun(run);
      progress.add(static_cast<uint64_t>(
                       run.count * volume(Vec3i{layout.cells(), layout.cells(), layout.cells()})) *
                   bytesPerVoxel(source.layout().type));
    });
    std::optional<double> background;
    if (occupancy) background = occupancy->background;
    builder.finish(background);
  });
  return result;
}

}  // namespace sluice
