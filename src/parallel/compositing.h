// Compositing: from the parts that ranks have drawn to the picture, which rank 0 gets.
//
// Tiles of the picture have owners. Each rank sends its part of a tile to the owner at once, only
// pixels that show something (partial_picture.h); the owner composes the parts in the order of
// layers; rank 0 gathers the finished tiles (Gao 2004, section 6). All ranks call.
#pragma once

#include <cstdint>

#include "src/base/threads/worker_pool.h"
#include "src/base/values/picture.h"
#include "src/device/pictures/partial_picture.h"
#include "src/parallel/communication/team.h"

namespace sluice {

// The rank that owns a tile, given its position in PartialPicture::tiles.
int ownerOf(size_t tile, int ranks);

// Costs of a picture on this rank.
struct CompositingReport {
  uint64_t part_bytes = 0;      // part that the rank drew
  uint64_t sent_bytes = 0;      // share of that part, sent to others
  uint64_t received_bytes = 0;  // parts of the rank's tiles, received from others
  double exchange_seconds = 0;  // waiting for others included
  double compose_seconds = 0, gather_seconds = 0;

  double seconds() const { return exchange_seconds + compose_seconds + gather_seconds; }
  // Adds the costs of a further picture of the same frame.
  CompositingReport& operator+=(const CompositingReport& more);
};

// `part` belongs to a frame of this setup, which is the same on all ranks except for what they
// drew; the part is consumed. If a rank's tiles would take more than `most_bytes`, all ranks throw
// Error. Rank 0 gets the picture; the others get an empty one.
Picture composite(Team& team, PartialPicture part, const FrameSetup& setup, WorkerPool& pool,
                  uint64_t most_bytes, CompositingReport& report);

}  // namespace sluice
