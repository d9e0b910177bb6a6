#include "src/index/stale_check.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/index/index_file.h"
#include "src/volume/block_ranges.h"

namespace sluice {
namespace {

template <class T>
PlaneRange<T> expectedRange(const SliceRanges& ranges, int64_t block) {
  const auto held = std::lower_bound(ranges.blocks.begin(), ranges.blocks.end(), block);
  if (held != ranges.blocks.end() && *held == block)
    return ranges.totalsAs<T>()[static_cast<size_t>(held - ranges.blocks.begin())];
  const T background = static_cast<T>(ranges.background);
  return {background, background};
}

// Of the voxels around the block's own cells: the arrays know nothing of ghost layers.
template <class T>
PlaneRange<T> foundRange(const BlockLayout& layout, int64_t block, const VolumeBlock& read) {
  const Box3 cells = layout.ownedCells(layout.indexOf(block));
  const Vec3i stored = read.voxels.size();
  return rangeOf(reinterpret_cast<const T*>(read.at(cells.lo)), cells.size() + Vec3i{1, 1, 1},
                 stored.x, stored.x * stored.y);
}

// What the user can do about it.
std::string removed(const std::filesystem::path& index) {
  if (index.empty()) return "open it again";
  if (removeIndices(index.parent_path()))
    return fmt::format("its index in {} was removed: give the same command again",
                       index.parent_path().string());
  return fmt::format("its index in {} cannot be removed: name another folder with --index-dir",
                     index.parent_path().string());
}

}  // namespace

void StaleCheck::expect(const BlockName& grid, const std::shared_ptr<const SliceRanges>& ranges) {
  const MutexLock lock(mutex_);
  std::erase_if(expected_, [](const auto& entry) { return entry.second.expired(); });
  expected_[grid.withBlock(0)] = ranges;
}

void StaleCheck::check(const BlockName& name, const VolumeBlock& block) const {
  std::shared_ptr<const SliceRanges> ranges;
  {
    const MutexLock lock(mutex_);
    const auto found = expected_.find(name.withBlock(0));
    if (found != expected_.end()) ranges = found->second.lock();
  }
  if (ranges == nullptr) return;
  visitDeviceType(ranges->map.type, [&](auto tag) {
    using T = decltype(tag);
    const PlaneRange<T> expected = expectedRange<T>(*ranges, name.block);
    const PlaneRange<T> found = foundRange<T>(ranges->layout, name.block, block);
    if (found.lo == expected.lo && found.hi == expected.hi) return;
    const auto value = [&](T device) { return ranges->map.valueOf(static_cast<double>(device)); };
    fail(
        "{}: block {} of time step {} has values from {} to {}, {} to {} when it was {}; the "
        "volume has changed, {}",
        name_, name.block, name.time, value(found.lo), value(found.hi), value(expected.lo),
        value(expected.hi), ranges->index_file.empty() ? "opened" : "indexed",
        removed(ranges->index_file));
  });
}

}  // namespace sluice
