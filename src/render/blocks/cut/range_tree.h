// RangeTree: the least and the greatest value below each block of a volume's coarser levels, from
// the ranges of the finest level's blocks. It does not depend on the look, and tells for any look
// of which parts nothing shows and of which everything does.
//
// Immutable once made; any thread may read.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/volume/pyramid.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

class RangeTree {
 public:
  // The range of the known finest blocks in the region of a block, in device values.
  struct Node {
    float lo = 0, hi = -1;  // of the known ones; lo > hi: there are none
    bool has_unknown = false;
  };

  RangeTree(const SliceRanges& finest, const PyramidLayout& pyramid, WorkerPool& pool);

  // Requires: level > 0.
  const Node& of(int level, int64_t block) const {
    return levels_[static_cast<size_t>(level) - 1][static_cast<size_t>(block)];
  }

 private:
  std::vector<std::vector<Node>> levels_;  // of each level above the finest, a node a block
};

}  // namespace sluice
