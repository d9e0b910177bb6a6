#include "src/volume/slice_ranges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "src/base/mutex.h"
#include "src/volume/block_ranges.h"
#include "src/volume/brick_ranges.h"
#include "src/volume/device_reader.h"
#include "src/volume/key_histogram.h"

namespace sluice {
namespace {

// A read and its converted voxels together take at most this many bytes on each thread, so that a
// row of a very wide volume is cut.
constexpr uint64_t kBytesPerRead = uint64_t{32} << 20;

// A run of neighbouring blocks along x, read together.
struct Run {
  Vec3i first;  // block index
  int64_t count;
};

// The voxel planes between which the block's owned cells lie.
Box3 ownedVoxels(const BlockLayout& layout, Vec3i index) {
  const Box3 cells = layout.ownedCells(index);
  return {cells.lo, cells.hi + Vec3i{1, 1, 1}};
}

// Volumes that are mostly nothing may have 2^90 voxels.
uint64_t voxelsOf(const BlockLayout& layout) {
  constexpr long double kMost = 1e18L;
  long double voxels = 1;
  for (int a = 0; a < 3; ++a) voxels *= static_cast<long double>(layout.dims[a]);
  return static_cast<uint64_t>(std::min(voxels, kMost));
}

int64_t blocksPerRead(const BlockLayout& layout, size_t voxel_bytes, uint64_t thread_bytes) {
  const auto bytes = static_cast<int64_t>(std::min(kBytesPerRead, thread_bytes));
  const int64_t block_bytes = volume(Vec3i{layout.cells(), layout.cells(), layout.cells()}) *
                              static_cast<int64_t>(voxel_bytes);
  return std::max<int64_t>(1, bytes / block_bytes);
}

std::vector<Run> runsOf(const BlockLayout& layout, const std::vector<int64_t>& blocks,
                        int64_t most) {
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
  const auto dropRepeats = [&blocks] {
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  };
  size_t drop_at = size_t{1} << 22;
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
    if (blocks.size() > drop_at) {
      dropRepeats();
      drop_at = std::max(drop_at, 2 * blocks.size());
    }
  }
  dropRepeats();
  return blocks;
}

// The work space of one thread for reading and counting. It is passed on from run to run, since
// fresh memory of this size costs as much as the work done in it.
template <class T>
struct WorkSpace {
  WorkSpace(VolumeSource& source, int64_t planes) : reader(source, kBytesPerRead), ranges(planes) {}

  // The device voxels of `box`, valid until the next call.
  const T* read(int64_t time, const Box3& box) {
    const auto count = static_cast<size_t>(box.count());
    if (count > capacity) {
      // Uninitialised on purpose: the read overwrites every byte.
      device = std::make_unique_for_overwrite<T[]>(count);
      capacity = count;
    }
    reader.read(time, {box, std::as_writable_bytes(std::span(device.get(), count))});
    return device.get();
  }

  DeviceReader reader;  // the run bounds the bytes of a read
  size_t capacity = 0;  // voxels
  std::unique_ptr<T[]> device;
  BlockRanges<T> ranges;
  KeyHistogram<T> histogram;
  PlaneRange<T> seen = kNoVoxels<T>;  // range of all voxels but NaN and infinities
  ValueRange far{1, 0};               // see SliceRanges::far_range
};

// `total`, the range of a block's voxels, without those that stand for NaN and infinities. They are
// rare, so that a second look at such a block costs nothing.
template <class T>
PlaneRange<T> numbersOf(PlaneRange<T> total, const T* voxels, Vec3i size, Vec3i stride_size) {
  if constexpr (std::is_same_v<T, float>) {
    if (total.lo > -kLargest && total.hi < kLargest) return total;
    total = kNoVoxels<T>;
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y) {
        const float* row = voxels + (z * stride_size.y + y) * stride_size.x;
        for (int64_t x = 0; x < size.x; ++x)
          if (row[x] > -kLargest && row[x] < kLargest) widen(total, {row[x], row[x]});
      }
  }
  return total;
}

void widenFar(ValueRange& range, const ValueRange& by) {
  if (by.lo > by.hi) return;
  range =
      range.lo > range.hi ? by : ValueRange{std::min(range.lo, by.lo), std::max(range.hi, by.hi)};
}

// Whether one of a block's device voxels stands for an infinity or for a value as far away.
bool hasFarVoxels(const float* voxels, Vec3i size, Vec3i stride_size) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const float* row = voxels + (z * stride_size.y + y) * stride_size.x;
      for (int64_t x = 0; x < size.x; ++x)
        if (std::abs(row[x]) == kLargest) return true;
    }
  return false;
}

// The range of the finite stored values of a box that are beyond kLargest; lo > hi: there are none.
ValueRange farRange(VolumeSource& source, int64_t time, const Box3& box) {
  const VoxelType type = source.layout().type;
  ValueRange range{1, 0};
  visitVoxelType(type, [&](auto tag) {
    using Stored = decltype(tag);
    if constexpr (std::is_floating_point_v<Stored>) {
      const auto count = static_cast<size_t>(box.count());
      const auto stored = std::make_unique_for_overwrite<Stored[]>(count);
      source.readRegion(time, box, std::as_writable_bytes(std::span(stored.get(), count)));
      for (size_t i = 0; i < count; ++i) {
        const auto value = static_cast<double>(stored[i]);
        if (std::isfinite(value) && std::abs(value) > double{kLargest})
          widenFar(range, {value, value});
      }
    }
  });
  return range;
}

// The device value outside the boxes that the source stores.
std::optional<double> backgroundOf(const VolumeSource& source,
                                   const std::optional<Occupancy>& occupancy) {
  if (!occupancy) return std::nullopt;
  return deviceFromStored(source.layout().type, occupancy->background);
}

template <class T>
class Builder {
 public:
  Builder(VolumeSource& source, int64_t time, SliceRanges& result,
          const std::optional<Occupancy>& occupancy)
      : source_(source),
        time_(time),
        result_(result),
        bricks_(brickGrid(brickCells(result.layout.dims, occupancy)),
                backgroundOf(source, occupancy)) {
    totals_.resize(result.blocks.size());
    planes_.resize(result.blocks.size() * perBlock());
  }

  void readRun(const Run& run) {
    const BlockLayout& layout = result_.layout;
    const Vec3i last = run.first + Vec3i{run.count - 1, 0, 0};
    const Box3 box = unite(ownedVoxels(layout, run.first), ownedVoxels(layout, last));
    const Vec3i size = box.size();
    std::unique_ptr<WorkSpace<T>> work = takeWorkSpace();
    const T* voxels = work->read(time_, box);
    bricks_.add(voxels, box);
    const auto held = static_cast<size_t>(
        std::lower_bound(result_.blocks.begin(), result_.blocks.end(), layout.idOf(run.first)) -
        result_.blocks.begin());
    for (int64_t i = 0; i < run.count; ++i) {
      const Box3 own = ownedVoxels(layout, run.first + Vec3i{i, 0, 0});
      const T* first = voxels + (own.lo.x - box.lo.x);
      const size_t at = held + static_cast<size_t>(i);
      totals_[at] = work->ranges.of(first, own.size(), size.x, size.x * size.y,
                                    planes_.data() + at * perBlock());
      widen(work->seen, numbersOf(totals_[at], first, own.size(), size));
      if constexpr (std::is_same_v<T, float>) {
        const bool may_be = totals_[at].hi >= kLargest || totals_[at].lo <= -kLargest;
        if (may_be && hasFarVoxels(first, own.size(), size))
          widenFar(work->far, farRange(source_, time_, own));
      }
    }
    // The last planes are the next blocks' first.
    Vec3i own = size;
    for (int a = 0; a < 3; ++a) own[a] -= last[a] + 1 < layout.grid[a] ? 1 : 0;
    for (int64_t z = 0; z < own.z; ++z)
      for (int64_t y = 0; y < own.y; ++y) {
        const T* row = voxels + (z * size.y + y) * size.x;
        work->histogram.add(row, own.x);
        work->histogram.addChanges(row, size.x);
      }
    const MutexLock lock(mutex_);
    idle_.push_back(std::move(work));
  }

  // To be called after the last run. Gives the bricks.
  BrickRanges finish(std::optional<double> known_background) {
    const MutexLock lock(mutex_);
    result_.background = known_background.value_or(mostCommonUniform());
    // A background that no block was read for is a value of the volume too.
    const bool unread = static_cast<int64_t>(totals_.size()) < result_.layout.blockCount();
    PlaneRange<T> seen = kNoVoxels<T>;
    if (unread) seen = numbersOf<T>({background(), background()}, nullptr, {}, {});
    KeyHistogram<T> histogram;
    for (const auto& work : idle_) {
      widen(seen, work->seen);
      widenFar(result_.far_range, work->far);
      histogram.add(work->histogram);
    }
    if (seen.lo <= seen.hi)
      result_.device_range = {static_cast<double>(seen.lo), static_cast<double>(seen.hi)};
    const uint64_t all = voxelsOf(result_.layout), counted = histogram.total();
    if (all > counted) histogram.add(background(), all - counted);
    result_.counts = histogram.finish(result_.device_range);
    keepOnlyNonBackground();
    const auto bytesOf = [](const auto& values) {
      const auto bytes = std::as_bytes(std::span(values));
      return std::vector<std::byte>(bytes.begin(), bytes.end());
    };
    result_.totals = bytesOf(totals_);
    result_.planes = bytesOf(planes_);
    return bricks_.finish();
  }

 private:
  size_t perBlock() const { return 3 * static_cast<size_t>(result_.layout.planes()); }
  T background() const { return static_cast<T>(result_.background); }
  bool isUniform(size_t held) const { return totals_[held].lo == totals_[held].hi; }

  std::unique_ptr<WorkSpace<T>> takeWorkSpace() {
    {
      const MutexLock lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<WorkSpace<T>> work = std::move(idle_.back());
        idle_.pop_back();
        return work;
      }
    }
    return std::make_unique<WorkSpace<T>>(source_, result_.layout.planes());
  }

  double mostCommonUniform() const {
    std::map<T, int64_t> counts;
    for (size_t i = 0; i < totals_.size(); ++i)
      if (isUniform(i)) ++counts[totals_[i].lo];
    int64_t most = 0;
    double value = 0;
    for (const auto& [candidate, count] : counts)
      if (count > most) {
        most = count;
        value = static_cast<double>(candidate);
      }
    return value;
  }

  void keepOnlyNonBackground() {
    size_t kept = 0;
    for (size_t i = 0; i < totals_.size(); ++i) {
      if (isUniform(i) && totals_[i].lo == background()) continue;
      if (kept != i) {
        totals_[kept] = totals_[i];
        result_.blocks[kept] = result_.blocks[i];
        std::copy_n(planes_.begin() + static_cast<ptrdiff_t>(i * perBlock()), perBlock(),
                    planes_.begin() + static_cast<ptrdiff_t>(kept * perBlock()));
      }
      ++kept;
    }
    totals_.resize(kept);
    planes_.resize(kept * perBlock());
    result_.blocks.resize(kept);
    result_.blocks.shrink_to_fit();
  }

  VolumeSource& source_;
  const int64_t time_;
  SliceRanges& result_;
  BrickRangesBuilder<T> bricks_;
  // Each run writes its own elements.
  std::vector<PlaneRange<T>> totals_, planes_;
  Mutex mutex_;
  std::vector<std::unique_ptr<WorkSpace<T>>> idle_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace

SliceRanges unknownRanges(VolumeSource& source, int64_t time, const BlockLayout& layout) {
  SliceRanges result;
  result.layout = layout;
  result.map = deviceMap(source.layout());
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  result.unknown = candidates(layout, occupancy);
  result.background = backgroundOf(source, occupancy).value_or(0);
  return result;
}

SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             WorkerPool& pool, ProgressMeter& progress, uint64_t most_bytes,
                             const StopToken& stop) {
  BrickRanges unused;
  return buildSliceRanges(source, time, layout, pool, progress, most_bytes, stop, unused);
}

SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             WorkerPool& pool, ProgressMeter& progress, uint64_t most_bytes,
                             const StopToken& stop, BrickRanges& bricks) {
  SliceRanges result;
  result.layout = layout;
  result.map = deviceMap(source.layout());
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  result.blocks = candidates(layout, occupancy);
  const size_t stored_bytes = bytesPerVoxel(source.layout().type);
  const std::vector<Run> runs =
      runsOf(layout, result.blocks,
             blocksPerRead(layout, stored_bytes + bytesPerVoxel(result.map.type),
                           most_bytes / static_cast<uint64_t>(pool.threads())));
  const auto block_bytes =
      static_cast<uint64_t>(volume(Vec3i{layout.cells(), layout.cells(), layout.cells()})) *
      stored_bytes;
  progress.expect(result.blocks.size() * block_bytes);
  visitDeviceType(result.map.type, [&](auto tag) {
    Builder<decltype(tag)> builder(source, time, result, occupancy);
    pool.parallelFor(static_cast<int64_t>(runs.size()), [&](int64_t i) {
      stop.throwIfStopped();
      const Run& run = runs[static_cast<size_t>(i)];
      builder.readRun(run);
      progress.add(static_cast<uint64_t>(run.count) * block_bytes);
    });
    bricks = builder.finish(backgroundOf(source, occupancy));
  });
  return result;
}

}  // namespace sluice
