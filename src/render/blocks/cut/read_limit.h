// ReadLimit: how much a picture that may not wait for its data reads. A cut through levels of
// resolution (level_cut.h) then refines a part only if the finer blocks are in memory or come in
// time, and shows the coarser block until all of them do. Plain data.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "src/classify/blocks/classification.h"

namespace sluice {

using VisibleBlocksPtr = std::shared_ptr<const VisibleBlocks>;

struct ReadLimit {
  uint64_t most_bytes = 0;  // of blocks that are not in memory, as the volume buffer holds them
  // One part is refined even if it takes more, so that each picture is better than the one before.
  bool refines_some = false;
  // Parts that the last picture refined stay refined until their voxels are clearly narrower than
  // the pixel error, so that nothing flickers while the view moves.
  bool keeps_refined = false;
  std::function<bool(const BlockName&)> is_in_memory;
  VisibleBlocksPtr last;  // the blocks of the last picture, all of them in memory; null: none
};

}  // namespace sluice
