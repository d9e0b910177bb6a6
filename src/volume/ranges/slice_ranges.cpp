#include "src/volume/ranges/slice_ranges.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "src/base/memory/aligned_array.h"
#include "src/base/threads/mutex.h"
#include "src/base/wide_vectors.h"
#include "src/volume/passes/key_histogram.h"
#include "src/volume/passes/pass_pieces.h"
#include "src/volume/passes/voxel_pass.h"
#include "src/volume/ranges/block_ranges.h"
#include "src/volume/ranges/brick_ranges.h"
#include "src/volume/ranges/far_voxels.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {
namespace {

// Columns of voxels whose ranges stay in the caches while the rows of a plane pass.
constexpr int64_t kColumnsAtOnce = 2048;

// Volumes that are mostly nothing may have 2^90 voxels.
uint64_t voxelsOf(const BlockLayout& layout) {
  constexpr long double kMost = 1e18L;
  long double voxels = 1;
  for (int a = 0; a < 3; ++a) voxels *= static_cast<long double>(layout.dims[a]);
  return static_cast<uint64_t>(std::min(voxels, kMost));
}

int64_t blocksPerRead(const BlockLayout& layout, size_t voxel_bytes, uint64_t thread_bytes) {
  const auto bytes = static_cast<int64_t>(std::min(kBytesPerRead, thread_bytes));
  // Neighbours share planes, so that a block of a run adds its own cells alone.
  const int64_t block_bytes = volume(Vec3i{layout.cells(), layout.cells(), layout.cells()}) *
                              static_cast<int64_t>(voxel_bytes);
  return std::max<int64_t>(1, bytes / block_bytes);
}

// The work space of one thread for reading and counting. It is passed on from run to run, since
// fresh memory of this size costs as much as the work done in it.
template <class T>
struct WorkSpace {
  WorkSpace(VolumeSource& source, int64_t side) : reader(source, kBytesPerRead), ranges(side) {}

  // The device voxels of `box`, valid until the next call.
  const T* read(int64_t time, const Box3& box) {
    const std::span<T> voxels = room(static_cast<size_t>(box.count()));
    reader.read(time, {box, std::as_writable_bytes(voxels)});
    return voxels.data();
  }
  // The same, after `taker` has seen the piece as it is stored.
  const T* read(VolumeSource& source, int64_t time, const PassPiece& piece, VoxelTaker& taker) {
    const VoxelType type = source.layout().type;
    const Vec3i size = piece.read.size();
    const auto count = static_cast<size_t>(piece.read.count());
    // Stored voxels as large as device voxels are converted in place. Doubles need room of their
    // own.
    const bool is_in_place = bytesPerVoxel(type) == sizeof(T);
    const std::span<std::byte> in_place = std::as_writable_bytes(room(count));
    const std::span<std::byte> read =
        is_in_place ? in_place : storedRoom(count * bytesPerVoxel(type));
    source.readRegion(time, piece.read, read);
    taker.take({piece.own, read.data(), size.x, size.x * size.y});
    if (!isStoredAsDevice(type)) toDevice(type, read, in_place);
    return device.get();
  }

  // Uninitialised on purpose: the read overwrites every byte.
  std::span<T> room(size_t count) {
    if (count > capacity) {
      device = alignedForOverwrite<T>(count);
      capacity = count;
    }
    return {device.get(), count};
  }
  std::span<std::byte> storedRoom(size_t bytes) {
    if (bytes > stored_capacity) {
      stored = alignedForOverwrite<std::byte>(bytes);
      stored_capacity = bytes;
    }
    return {stored.get(), bytes};
  }

  DeviceReader reader;  // the piece bounds the bytes of a read
  size_t capacity = 0;  // voxels
  AlignedArray<T> device;
  size_t stored_capacity = 0;
  AlignedArray<std::byte> stored;  // voxels that are larger than device voxels
  RowRanges<T> ranges;
  std::vector<PlaneRange<T>> totals, planes;  // of the blocks of a piece, from that piece alone
  KeyHistogram<T> histogram;
  PlaneRange<T> seen = kNoVoxels<T>;  // range of all voxels but NaN and infinities
  ValueRange far{1, 0};               // see SliceRanges::far_range
};

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
        bricks_(brickGrid(brickCells(result.layout.dims, occupancy))) {
    // Blocks outside the stored boxes are not read: all their voxels are the background.
    if (const std::optional<double> background = backgroundOf(source, occupancy))
      bricks_.addBackground(*background, result.layout, result.blocks);
    totals_.resize(result.blocks.size(), kNoVoxels<T>);
    planes_.resize(result.blocks.size() * perBlock(), kNoVoxels<T>);
  }

  // Any thread. `taker`: null if nobody else wants the voxels.
  void takePiece(const PassPiece& piece, VoxelTaker* taker) {
    std::unique_ptr<WorkSpace<T>> work = takeWorkSpace();
    const T* voxels = taker == nullptr ? work->read(time_, piece.read)
                                       : work->read(source_, time_, piece, *taker);
    inWideVectors([&] { bricks_.add(voxels, piece.read); });
    takeBlocks(piece, voxels, *work);
    const Vec3i size = piece.read.size();
    const Vec3i own = piece.own.size();
    for (int64_t z = 0; z < own.z; ++z)
      for (int64_t y = 0; y < own.y; ++y) {
        const T* row = voxels + (z * size.y + y) * size.x;
        work->histogram.add(row, own.x);
        work->histogram.addChanges(row, size.x);
      }
    // Passed on to the next piece of any thread, and asked for its counts in finish().
    const MutexLock lock(mutex_);
    idle_.push_back(std::move(work));
  }

  // To be called after the last piece. Gives the bricks.
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
    // Voxels of blocks that were not read are all background.
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
  // The part of a held block that a piece has.
  struct Part {
    size_t held;
    Vec3i shift;  // its first plane among the block's
    Box3 box;     // voxels
  };

  // Widens the arrays of the piece's blocks: several pieces may hold parts of a block.
  void takeBlocks(const PassPiece& piece, const T* voxels, WorkSpace<T>& work) {
    std::vector<Part> parts;
    work.totals.clear();
    work.planes.resize(static_cast<size_t>(piece.blocks.count()) * perBlock());
    const Box3& blocks = piece.blocks;
    for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
      for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y)
        takeRow(piece, {{blocks.lo.x, y, z}, {blocks.hi.x, y + 1, z + 1}}, voxels, work, parts);
    // One lock a piece: other pieces may hold parts of the same blocks.
    const int64_t planes = result_.layout.planes();
    const MutexLock lock(mutex_);
    for (size_t i = 0; i < parts.size(); ++i) {
      const Part& part = parts[i];
      widen(totals_[part.held], work.totals[i]);
      for (int a = 0; a < 3; ++a) {
        const PlaneRange<T>* from = work.planes.data() + i * perBlock() + a * planes;
        PlaneRange<T>* to = planes_.data() + part.held * perBlock() + a * planes + part.shift[a];
        for (int64_t plane = 0; plane < part.box.size()[a]; ++plane) widen(to[plane], from[plane]);
      }
    }
  }

  // The ranges of one row of the piece's blocks, which are added to those of `work`. The blocks are
  // taken together: rows of one block, 62 bytes of u8, left vector units half full.
  void takeRow(const PassPiece& piece, const Box3& row, const T* voxels, WorkSpace<T>& work,
               std::vector<Part>& parts) {
    const Vec3i size = piece.read.size();
    const size_t before = parts.size();
    const auto firstVoxel = [&](const Box3& box) {
      const Vec3i at = box.lo - piece.read.lo;
      return voxels + (at.z * size.y + at.y) * size.x + at.x;
    };
    // Blocks outside the stored boxes are not in the list, so that rows may have gaps.
    eachHeld(row, [&](size_t held, Vec3i index) {
      const Box3 whole = result_.layout.ownedVoxels(index), part = intersect(whole, piece.read);
      parts.push_back({held, part.lo - whole.lo, part});
    });
    work.totals.resize(parts.size());
    for (size_t first = before, end = first; first < parts.size(); first = end) {
      // Blocks without a gap, as many as the caches like.
      while (++end < parts.size() && parts[end].box.lo.x <= parts[end - 1].box.hi.x &&
             parts[end].box.hi.x - parts[first].box.lo.x <= kColumnsAtOnce) {
      }
      const Box3 all = unite(parts[first].box, parts[end - 1].box);
      std::vector<BlockColumns> columns;
      for (size_t i = first; i < end; ++i)
        columns.push_back({parts[i].box.lo.x - all.lo.x, parts[i].box.size().x});
      inWideVectors([&] {
        work.ranges.of(firstVoxel(all), all.size(), size.x, size.x * size.y, columns,
                       work.planes.data() + first * perBlock(), work.totals.data() + first);
      });
    }
    for (size_t i = before; i < parts.size(); ++i) {
      const PlaneRange<T> total = work.totals[i];
      const Box3& part = parts[i].box;
      // kLargest stands for infinities and for values beyond it. Only the stored voxels tell which,
      // and few blocks have any.
      widen(work.seen, numbersOf(total, firstVoxel(part), part.size(), size));
      if constexpr (std::is_same_v<T, float>) {
        const bool may_be = total.hi >= kLargest || total.lo <= -kLargest;
        if (may_be && hasFarVoxels(firstVoxel(part), part.size(), size))
          widenFar(work.far, farRange(source_, time_, part));
      }
    }
  }

  // Calls f(held, index) for the blocks of a box of indices that are held so far.
  template <class F>
  void eachHeld(const Box3& blocks, F&& f) const {
    const BlockLayout& layout = result_.layout;
    for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
      for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) {
        // The list has only candidates, in ascending order: those of the row follow each other in
        // it.
        const int64_t first = layout.idOf({blocks.lo.x, y, z}), end = first + blocks.size().x;
        for (auto it = std::lower_bound(result_.blocks.begin(), result_.blocks.end(), first);
             it != result_.blocks.end() && *it < end; ++it)
          f(static_cast<size_t>(it - result_.blocks.begin()), layout.indexOf(*it));
      }
  }

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
    // The most common uniform value, so that the most blocks need not be held. Of equals the least,
    // as the map is ordered: the result does not depend on threads.
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
    // Compacts all three arrays in place, so that the pass needs no second copy of them.
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
  Mutex mutex_;
  std::vector<PlaneRange<T>> totals_, planes_;  // guarded by mutex_ until finish()
  std::vector<std::unique_ptr<WorkSpace<T>>> idle_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace

SliceRanges unknownRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                          Listing listing) {
  SliceRanges result;
  result.layout = layout;
  result.map = deviceMap(source.layout());
  result.is_listed = listing == Listing::kNow;
  std::optional<Occupancy> occupancy;
  if (result.is_listed) occupancy = source.occupancy(time);
  result.unknown = candidateBlocks(layout, occupancy);
  result.background = backgroundOf(source, occupancy).value_or(0);
  return result;
}

std::shared_ptr<const SliceRanges> listedRanges(std::shared_ptr<const SliceRanges> ranges,
                                                VolumeSource& source, int64_t time) {
  if (ranges->is_listed) return ranges;
  auto listed = std::make_shared<SliceRanges>(*ranges);
  listed->is_listed = true;
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  // Any block of a source without a listing may hold something: all of them stay unknown.
  if (!occupancy) return listed;
  listed->background = *backgroundOf(source, occupancy);
  const std::vector<int64_t> candidates = candidateBlocks(ranges->layout, occupancy);
  listed->unknown.clear();
  std::ranges::set_intersection(ranges->unknown, candidates, std::back_inserter(listed->unknown));
  return listed;
}

SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             const VolumePass& pass) {
  BrickRanges unused;
  return buildSliceRanges(source, time, layout, pass, unused);
}

SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             const VolumePass& pass, BrickRanges& bricks, VoxelTaker* taker) {
  SliceRanges result;
  result.layout = layout;
  result.map = deviceMap(source.layout());
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  result.blocks = candidateBlocks(layout, occupancy);
  const size_t stored_bytes = bytesPerVoxel(source.layout().type);
  const size_t voxel_bytes = stored_bytes + bytesPerVoxel(result.map.type);
  // A thread's voxels as they are stored and as device voxels are held at the same time.
  const uint64_t thread_bytes = pass.memory_bytes / static_cast<uint64_t>(pass.pool.threads());
  const PassedVoxels passed{source, time, layout, result.blocks, pass};
  visitDeviceType(result.map.type, [&](auto tag) {
    Builder<decltype(tag)> builder(source, time, result, occupancy);
    const TakePiece take = [&](const PassPiece& piece) { builder.takePiece(piece, taker); };
    // Without a taker any pieces will do, and runs of blocks read only what may differ from the
    // background.
    if (taker == nullptr) {
      const std::vector<PassPiece> runs =
          runsOf(layout, result.blocks, blocksPerRead(layout, voxel_bytes, thread_bytes));
      uint64_t voxels = 0;
      for (const PassPiece& run : runs) voxels += static_cast<uint64_t>(run.own.count());
      pass.progress.expect(voxels * stored_bytes);
      passPieces(passed, runs, runs.size(), [&](const PassPiece& run) {
        take(run);
        pass.progress.add(static_cast<uint64_t>(run.own.count()) * stored_bytes);
      });
    } else {
      passInTiles(passed, voxelsPerTile(voxel_bytes, thread_bytes), PassLayers::kAll, *taker, take);
    }
    bricks = builder.finish(backgroundOf(source, occupancy));
  });
  return result;
}

}  // namespace sluice
