#include "src/volume/ranges/learnt_ranges.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "src/volume/ranges/block_ranges.h"

namespace sluice {
namespace {

// The arrays tell of the voxels around the block's own cells, as in an index.
template <class T>
std::vector<PlaneRange<T>> arraysOf(const BlockLayout& layout, int64_t block,
                                    const VolumeBlock& read) {
  const Box3 own = layout.ownedVoxels(layout.indexOf(block));
  const Vec3i stored = read.voxels.size(), size = own.size();
  const int64_t planes = layout.planes();
  std::vector<PlaneRange<T>> arrays(static_cast<size_t>(1 + 3 * planes));
  const BlockColumns all{0, size.x};
  RowRanges<T>(planes).of(reinterpret_cast<const T*>(read.at(own.lo)), size, stored.x,
                          stored.x * stored.y, std::span(&all, 1), arrays.data() + 1,
                          arrays.data());
  return arrays;
}

// The known ranges with further blocks, which are unknown to them.
template <class T>
SliceRanges withBlocks(const SliceRanges& known,
                       const std::map<int64_t, std::vector<std::byte>>& fresh) {
  SliceRanges all = known;
  // A fresh block is known from now on, background or not.
  std::erase_if(all.unknown, [&](int64_t block) { return fresh.contains(block); });
  all.blocks.clear();
  all.totals.clear();
  all.planes.clear();
  const size_t total_bytes = sizeof(PlaneRange<T>);
  const size_t plane_bytes = total_bytes * 3 * static_cast<size_t>(known.layout.planes());
  const auto add = [&](int64_t block, const std::byte* total, const std::byte* planes) {
    all.blocks.push_back(block);
    all.totals.insert(all.totals.end(), total, total + total_bytes);
    all.planes.insert(all.planes.end(), planes, planes + plane_bytes);
  };
  size_t held = 0;
  const auto addHeldBefore = [&](int64_t block) {
    for (; held < known.blocks.size() && known.blocks[held] < block; ++held)
      add(known.blocks[held], known.totals.data() + held * total_bytes,
          known.planes.data() + held * plane_bytes);
  };
  for (const auto& [block, arrays] : fresh) {
    addHeldBefore(block);
    PlaneRange<T> total{};
    std::memcpy(&total, arrays.data(), sizeof total);
    const T background = static_cast<T>(known.background);
    // Ranges that are not listed hold all known blocks, because their background is not known yet.
    if (known.is_listed && total.lo == background && total.hi == background) continue;
    add(block, arrays.data(), arrays.data() + total_bytes);
  }
  addHeldBefore(known.layout.blockCount());
  return all;
}

}  // namespace

void LearntRanges::note(const BlockName& name, const VolumeBlock& block) {
  if (name.level != 0 || name.time != time_) return;
  std::shared_ptr<const SliceRanges> known;
  {
    const MutexLock lock(mutex_);
    known = known_;
    if (bytes_ >= kMostBytes || known->isKnown(name.block) || fresh_.contains(name.block)) return;
  }
  // The ranges are made without the lock, since other threads read blocks meanwhile. Two threads
  // may make those of one block.
  Arrays bytes = visitDeviceType(block.type, [&](auto tag) {
    const auto arrays = arraysOf<decltype(tag)>(known->layout, name.block, block);
    const auto raw = std::as_bytes(std::span(arrays));
    return Arrays(raw.begin(), raw.end());
  });
  const MutexLock lock(mutex_);
  const uint64_t more = bytes.size();
  // ranges() may have taken it over in between.
  if (known_->isKnown(name.block)) return;
  if (fresh_.emplace(name.block, std::move(bytes)).second) bytes_ += more;
}

std::shared_ptr<const SliceRanges> LearntRanges::ranges() {
  const MutexLock lock(mutex_);
  if (fresh_.empty()) return known_;
  // Clang does not see in a lambda that its caller holds the lock, so these are taken out before.
  const std::shared_ptr<const SliceRanges> known = known_;
  const auto fresh = std::exchange(fresh_, {});
  known_ = visitDeviceType(known->map.type, [&](auto tag) {
    return std::make_shared<const SliceRanges>(withBlocks<decltype(tag)>(*known, fresh));
  });
  return known_;
}

}  // namespace sluice
