#include "tools/plan/plan_boxes.h"

#include <nlohmann/json.hpp>

#include <algorithm>

#include "src/base/threads/clock.h"
#include "src/index/box_store.h"
#include "src/library/drawing/scene/resources.h"
#include "tools/command_line/console.h"
#include "tools/command_line/progress_line.h"
#include "tools/scene/open_scene.h"

namespace sluice {

PlannedBoxes planBoxes(const BoxesWish& wish, const IndexedVolume& volume,
                       const PlannedBlocks& shown, WorkerPool& pool) {
  const SliceRanges& ranges = volume.index->ranges;
  const Box3 crop = cropCells(wish.frame, ranges.layout.dims);
  PlannedBoxes planned;
  for (const ObjectBlock& block : shown.blocks->blocks) {
    ++planned.object_boxes;
    planned.object_cells += block.cells.count();
  }
  Stopwatch watch;
  ProgressMeter progress =
      wish.resources.quiet ? ProgressMeter() : ProgressMeter(progressLine("growing boxes"));
  // The pass is made for the bricks; the boxes that a picture needs are kept on the way.
  BoxIndexWriter index(*volume.source, volume.places, wish.time, ranges);
  VolumePass pass = passOf(pool, progress, wish.resources);
  // The other half holds what the plan is made of.
  pass.memory_bytes = std::min(pass.memory_bytes / 2, kMostGrowingBytes);
  planned.cost = partitionCost(*volume.source, wish.time, ranges, shown.look->table, crop, pass,
                               [&](int64_t block, const BoxTree& tree) { index.add(block, tree); });
  planned.pieces_kept = index.piecesWritten();
  planned.seconds = watch.lap();
  return planned;
}

void print(const PlannedBoxes& planned) {
  const PartitionCost& cost = planned.cost;
  const auto share = [&](int64_t cells) {
    return cost.perfect_cells == 0
               ? 0.0
               : static_cast<double>(cells) / static_cast<double>(cost.perfect_cells);
  };
  say("\n{:<16} {:>9} {:>14} {:>9}   cells that a frame samples\n", "partition", "visible", "cells",
      "of 8^3");
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "object boxes", planned.object_boxes, planned.object_cells,
      share(planned.object_cells));
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "growing boxes", cost.visible_boxes, cost.visible_cells,
      share(cost.visible_cells));
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "bricks of 8^3", cost.perfect_bricks, cost.perfect_cells,
      share(cost.perfect_cells));
  say("{} boxes grown, {} in BSP trees ({} uniform, {} gradient, {} other) with {} textures; "
      "{} blocks read and partitioned in {:.2f} s\n",
      cost.grown, cost.boxes, cost.types[0], cost.types[1], cost.types[2], cost.textures,
      cost.blocks, planned.seconds);
}

nlohmann::json boxesJson(const PlannedBoxes& planned) {
  const PartitionCost& cost = planned.cost;
  return {{"boxes", cost.boxes},
          {"grown_boxes", cost.grown},
          {"textures", cost.textures},
          {"uniform_boxes", cost.types[0]},
          {"gradient_boxes", cost.types[1]},
          {"other_boxes", cost.types[2]},
          {"visible_boxes", cost.visible_boxes},
          {"visible_cells", cost.visible_cells},
          {"object_boxes", planned.object_boxes},
          {"object_cells", planned.object_cells},
          {"perfect_bricks", cost.perfect_bricks},
          {"perfect_cells", cost.perfect_cells},
          {"blocks_read", cost.blocks},
          {"index_pieces", planned.pieces_kept},
          {"seconds", planned.seconds}};
}

}  // namespace sluice
