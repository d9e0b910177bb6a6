// SpreadTally: the spreads of coarse blocks as they are read, so that a report can state how much
// the values vary below the voxels that a picture shows.
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
  // Notes the spreads of a block that was just read; a block without spreads is ignored.
  void note(const BlockName& name, const VolumeBlock& block) SLUICE_EXCLUDES(mutex_);
  // The spreads of all blocks of a picture that were read so far, in units of values; nullopt if
  // none of its blocks has spreads. `scale`: values in a device value.
  std::optional<StandingSpread> of(const VisibleBlocks& blocks, double scale) const
      SLUICE_EXCLUDES(mutex_);

 private:
  // Device values.
  struct Spreads {
    double largest = 0, mean = 0;
  };

  mutable Mutex mutex_;
  // A few bytes for each coarse block ever read: a thousandth of the block itself.
  std::unordered_map<BlockName, Spreads, BlockNameHash> by_block_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
