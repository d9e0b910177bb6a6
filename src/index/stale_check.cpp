#include "src/index/stale_check.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/index/index_file.h"
#include "src/volume/ranges/block_ranges.h"

namespace sluice {
namespace {

// The values are those of the voxels around the block's own cells: the arrays know nothing of ghost
// layers.
template <class T>
BlockValues foundValues(const BlockLayout& layout, int64_t block, const VolumeBlock& read) {
  const Box3 cells = layout.ownedCells(layout.indexOf(block));
  const Vec3i stored = read.voxels.size();
  const PlaneRange<T> range = rangeOf(reinterpret_cast<const T*>(read.at(cells.lo)),
                                      cells.size() + Vec3i{1, 1, 1}, stored.x, stored.x * stored.y);
  return {static_cast<double>(range.lo), static_cast<double>(range.hi)};
}

// The end of the message: what the user can do about it.
std::string removed(const std::filesystem::path& index) {
  if (index.empty()) return "open it again";
  // The index is removed, because it would fail the next opening, too.
  if (removeIndices(index.parent_path()))
    return fmt::format("its index in {} was removed: give the same command again",
                       index.parent_path().string());
  return fmt::format("its index in {} cannot be removed: name another folder with --index-dir",
                     index.parent_path().string());
}

}  // namespace

BlockValues expectedValues(const SliceRanges& ranges, int64_t block) {
  const auto held = std::lower_bound(ranges.blocks.begin(), ranges.blocks.end(), block);
  // Blocks that are not held are background.
  if (held == ranges.blocks.end() || *held != block) return {ranges.background, ranges.background};
  const auto at = static_cast<size_t>(held - ranges.blocks.begin());
  return visitDeviceType(ranges.map.type, [&](auto tag) -> BlockValues {
    const auto range = ranges.totalsAs<decltype(tag)>()[at];
    return {static_cast<double>(range.lo), static_cast<double>(range.hi)};
  });
}

void expectSameValues(const BlockName& name, const BlockValues& found, const BlockValues& expected,
                      const ExpectedOrigin& origin) {
  if (found == expected) return;
  const ValueMap& map = origin.map;
  fail(
      "{}: block {} of time step {} has values from {} to {}, {} to {} when it was {}; the "
      "volume has changed, {}",
      origin.volume, name.block, name.time, map.valueOf(found.lo), map.valueOf(found.hi),
      map.valueOf(expected.lo), map.valueOf(expected.hi),
      origin.index_file.empty() ? "opened" : "indexed", removed(origin.index_file));
}

void StaleCheck::expect(const BlockName& grid, const std::shared_ptr<const SliceRanges>& ranges) {
  const MutexLock lock(mutex_);
  // Steps that nobody draws any more are forgotten here, so that a long series does not grow.
  std::erase_if(expected_, [](const auto& entry) { return entry.second.expired(); });
  expected_[grid.withBlock(0)] = ranges;
}

void StaleCheck::check(const BlockName& name, const VolumeBlock& block) const {
  std::shared_ptr<const SliceRanges> ranges;
  {
    const MutexLock lock(mutex_);
    // The lock is held for the look-up alone: blocks are compared on all reading threads.
    const auto found = expected_.find(name.withBlock(0));
    if (found != expected_.end()) ranges = found->second.lock();
  }
  // Unknown blocks have no ranges to compare with.
  if (ranges == nullptr || !ranges->isKnown(name.block)) return;
  const BlockValues found = visitDeviceType(ranges->map.type, [&](auto tag) {
    return foundValues<decltype(tag)>(ranges->layout, name.block, block);
  });
  expectSameValues(name, found, expectedValues(*ranges, name.block),
                   {name_, ranges->map, ranges->index_file});
}

}  // namespace sluice
