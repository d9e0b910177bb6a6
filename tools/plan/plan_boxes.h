// The part of `sluice plan` about growing boxes (Li 2003), for --partition boxes.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>

#include "src/base/threads/worker_pool.h"
#include "src/index/volume_boxes.h"
#include "src/library/drawing/cost/picture_cost.h"
#include "tools/options/arguments.h"

namespace sluice {

// Growing boxes, compared with the two partitions that they lie between: one object box a block,
// and bricks that know the transfer function.
struct PlannedBoxes {
  PartitionCost cost;
  int64_t object_boxes = 0, object_cells = 0;
  int64_t pieces_kept = 0;  // pieces of the index
  double seconds = 0;
};

struct BoxesWish {
  const FrameOptions& frame;
  const ResourceArguments& resources;
  int64_t time = 0;
};
// Reads the blocks that show something, and keeps their boxes with the volume's index. Throws
// Error, Interrupted.
PlannedBoxes planBoxes(const BoxesWish& wish, const IndexedVolume& volume,
                       const PlannedBlocks& shown, WorkerPool& pool);

// A table for people, and the same as JSON.
void print(const PlannedBoxes& planned);
nlohmann::json boxesJson(const PlannedBoxes& planned);

}  // namespace sluice
