#include "src/render/blocks/losses/spread_tally.h"

#include <algorithm>
#include <cmath>

namespace sluice {

void SpreadTally::note(const BlockName& name, const VolumeBlock& block) {
  if (block.numbers != 2) return;
  Spreads spreads;
  visitDeviceType(block.type, [&](auto zero) {
    using T = decltype(zero);
    const auto* of = reinterpret_cast<const T*>(block.bytes.get() + block.planeBytes());
    const int64_t count = block.voxels.count();
    T largest = 0;
    double sum = 0;
    // A voxel of nothing but NaN has a spread below 0.
    for (int64_t i = 0; i < count; ++i) {
      const T spread = std::max(of[i], T{0});
      largest = std::max(largest, spread);
      sum += static_cast<double>(spread);
    }
    spreads = {static_cast<double>(largest), sum / static_cast<double>(count)};
  });
  const MutexLock lock(mutex_);
  // Bounded, so that a long run does not grow.
  if (by_block_.size() >= kMostBlocks && !by_block_.contains(name)) by_block_.clear();
  by_block_[name] = spreads;
}

std::optional<StandingSpread> SpreadTally::of(const VisibleBlocks& blocks, double scale) const {
  StandingSpread standing;
  double cells = 0, sum = 0;
  const MutexLock lock(mutex_);
  for (const ObjectBlock& block : blocks.blocks) {
    const auto found = by_block_.find(block.name);
    if (found == by_block_.end()) continue;
    // The cells that the picture shows are the weight: a block that hardly shows counts little.
    const auto weight = static_cast<double>(block.cells.count());
    // A negative scale turns values round, but a spread stays one.
    standing.largest = std::max(standing.largest, found->second.largest * std::abs(scale));
    sum += weight * found->second.mean * std::abs(scale);
    cells += weight;
  }
  if (!(cells > 0)) return std::nullopt;
  standing.mean = sum / cells;
  return standing;
}

}  // namespace sluice
