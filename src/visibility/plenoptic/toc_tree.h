// TocTree: which blocks' opacity functions change from one time step to another, found without
// looking at all of them (Gao 2004, section 5.3).
//
// An octree over the grid of blocks. A node knows at which time steps a coherent span of any block
// below it begins, a bit each; the leaves are the result of block fusion, and a node has the bits
// of its children: built bottom-up. Immutable once made; any thread may ask.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {

class TocTree {
 public:
  // `begins`: for each block of the grid, x fastest, the steps at which a span begins; step 0, at
  // which all begin, may be left out. Each within 1 <= step < steps.
  TocTree(Vec3i grid, int64_t steps, const std::vector<std::vector<int32_t>>& begins);

  // The blocks, by id, of which a span begins after step `from` and not after step `to`, or the
  // other way round: blocks whose functions belong to different spans. The ids have no order.
  std::vector<int64_t> changedBetween(int64_t from, int64_t to) const;

  uint64_t bytes() const { return bits_.size() * sizeof(uint64_t); }
  int64_t nodes() const;
  // The nodes' bits, level after level from the leaves, as they are kept in files.
  std::span<const uint64_t> bits() const { return bits_; }

 private:
  struct Level {
    Vec3i grid;
    size_t first = 0;  // index of its first node
  };
  TocTree(Vec3i grid, int64_t steps);
  size_t nodeAt(const Level& level, Vec3i index) const;
  bool beginsWithin(size_t node, int64_t first, int64_t last) const;
  void sumChildren(size_t level, Vec3i index, std::span<uint64_t> words) const;

  int64_t steps_, words_;
  std::vector<Level> levels_;  // the leaves first, the root last
  std::vector<uint64_t> bits_;
};

}  // namespace sluice
