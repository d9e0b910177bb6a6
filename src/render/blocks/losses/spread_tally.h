// SpreadTally: the spreads of coarse blocks as they are read, so that a report can state how much
// the values vary below the voxels that a picture shows; or, of labels, the shares of others.
//
// Any thread may call.
#pragma once

#include <unordered_map>

#include "src/base/threads/mutex.h"
#include "src/classify/blocks/cut_summary.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

class SpreadTally {
 public:
  // It notes at most so many blocks, and forgets all when more are read. Each takes about so many
  // bytes: a node of the table and its place.
  static constexpr size_t kMostBlocks = size_t{1} << 17, kBlockBytes = 80;

  // Notes the spreads of a block that was just read; a block without spreads is ignored.
  void note(const BlockName& name, const VolumeBlock& block) SLUICE_EXCLUDES(mutex_);
  // The spreads of all blocks of a picture that were read and not forgotten so far, times `scale`;
  // nullopt if none of its blocks has spreads.
  std::optional<StandingSpread> of(const VisibleBlocks& blocks, double scale) const
      SLUICE_EXCLUDES(mutex_);

 private:
  // Device values.
  struct Spreads {
    double largest = 0, mean = 0;
  };

  mutable Mutex mutex_;
  std::unordered_map<BlockName, Spreads, BlockNameHash> by_block_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
