// Compositing: from the parts that ranks have drawn to the picture, which rank 0 gets.
//
// Tiles of the picture have owners. Each rank sends what it drew of a tile to its owner at once,
// pixels that show something alone (partial_picture.h); the owner puts the parts together in the
// order of layers; rank 0 gathers the finished tiles (Gao 2004, section 6). All ranks call.
#pragma once

#include <cstdint>

#include "src/base/picture.h"
#include "src/base/worker_pool.h"
#include "src/device/partial_picture.h"
#include "src/parallel/team.h"

namespace sluice {

// Of a tile, by its position in PartialPicture::tiles.
int ownerOf(size_t tile, int ranks);

// What a picture took of this rank.
struct CompositingReport {
  uint64_t part_bytes = 0;      // that it drew
  uint64_t sent_bytes = 0;      // of them, to others
  uint64_t received_bytes = 0;  // of its tiles, from others
  double exchange_seconds = 0;  // waiting for others included
  double compose_seconds = 0, gather_seconds = 0;
};

// `part` is of a frame of this setup, alike on all ranks but for what they drew; nothing of it is
// left. Where a rank's tiles would take more than `most_bytes` all throw Error. The picture is rank
// 0's, elsewhere it is empty.
Picture composite(Team& team, PartialPicture part, const FrameSetup& setup, WorkerPool& pool,
                  uint64_t most_bytes, CompositingReport& report);

}  // namespace sluice
