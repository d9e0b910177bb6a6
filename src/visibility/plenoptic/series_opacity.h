// SeriesOpacity: the opacity functions of all blocks of all time steps of a series, one for each
// coherent span of a block, and the tree that finds the changes from step to step (Gao 2004,
// sections 4 and 5). The visibility estimate works from this alone; it needs no voxel. Immutable
// once made; any thread may read.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/visibility/plenoptic/opacity_function.h"
#include "src/visibility/plenoptic/toc_tree.h"

namespace sluice {

// A span of one block, from step `first` until the next span begins.
struct CoherentSpan {
  int32_t first = 0;
  int32_t function = 0;  // position in SeriesOpacity::functions
  friend bool operator==(const CoherentSpan&, const CoherentSpan&) = default;
};

struct SeriesOpacity {
  Vec3i dims;               // voxels of the volume
  Vec3i grid;               // blocks along each axis
  int64_t block_cells = 0;  // a side of an inner block
  int64_t part_cells = 4;   // a side of a part: kDetail cubes
  int64_t steps = 1;
  DirectionGrid directions;
  std::vector<OpacityFunction> functions;  // each once, however many spans have it
  std::vector<CoherentSpan> spans;         // block after block, ascending by step
  std::vector<uint32_t>
      first_span;  // index of each block's first span, and behind the last: blocks + 1
  std::optional<TocTree> tree;

  int64_t blockCount() const { return volume(grid); }
  Vec3i indexOf(int64_t block) const {
    return {block % grid.x, block / grid.x % grid.y, block / (grid.x * grid.y)};
  }
  // The cells that the block owns.
  Box3 cellsOf(int64_t block) const {
    const Vec3i lo = indexOf(block) * block_cells;
    return {lo, min(lo + Vec3i{block_cells, block_cells, block_cells}, dims - Vec3i{1, 1, 1})};
  }
  PartGrid partsOf(int64_t block) const { return {cellsOf(block).size(), part_cells}; }
  PartGrid cubesOf(int64_t block) const { return {cellsOf(block).size(), part_cells / kDetail}; }
  std::span<const CoherentSpan> spansOf(int64_t block) const {
    const auto b = static_cast<size_t>(block);
    return std::span(spans).subspan(first_span[b], first_span[b + 1] - first_span[b]);
  }
  // Position in `functions` of the one for the block at a step.
  int32_t functionAt(int64_t block, int64_t step) const;
  // Bytes of functions and spans.
  uint64_t bytes() const;
};
using SeriesOpacityPtr = std::shared_ptr<const SeriesOpacity>;

// Puts the spans of single blocks together: equal functions become one, and the tree is built.
// `spans`: of each block, with positions in the block's own list of functions.
struct BlockOpacity {
  std::vector<CoherentSpan> spans;
  std::vector<OpacityFunction> functions;
};
void gather(SeriesOpacity& series, std::vector<BlockOpacity> blocks);

// A member of a family of transfer functions, computed from the functions of its basis (equation
// 4). A block's span ends where a span of any basis with an exponent above 0 ends. Requires: the
// same blocks, steps, parts and directions in all, and an exponent for each.
SeriesOpacity combined(std::span<const SeriesOpacity* const> bases,
                       std::span<const double> exponents);

}  // namespace sluice
