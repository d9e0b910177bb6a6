#include "src/volume/passes/pass_pieces.h"

#include <algorithm>

#include "src/base/values/number_set.h"

namespace sluice {
namespace {

// The indices of the blocks that own a voxel of a box: a voxel on a shared plane belongs to the
// blocks on both sides.
Box3 blocksAround(const BlockLayout& layout, const Box3& voxels) {
  Box3 blocks;
  for (int a = 0; a < 3; ++a) {
    // A voxel on a plane between two blocks belongs to both, so the block before it counts, too.
    blocks.lo[a] = std::max<int64_t>(0, voxels.lo[a] - 1) / layout.cells();
    blocks.hi[a] = std::min(layout.grid[a], (voxels.hi[a] - 1) / layout.cells() + 1);
  }
  return blocks;
}

// Calls `call` with the first block and the end of each row of blocks around the boxes.
template <class Call>
void eachRow(const BlockLayout& layout, const std::vector<Box3>& boxes, const Call& call) {
  for (const Box3& box : boxes) {
    if (box.empty()) continue;
    const Box3 blocks = blocksAround(layout, box);
    for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
      for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) {
        const int64_t first = layout.idOf({blocks.lo.x, y, z});
        call(first, first + blocks.size().x);
      }
  }
}

}  // namespace

std::vector<int64_t> candidateBlocks(const BlockLayout& layout,
                                     const std::optional<Occupancy>& occupancy) {
  std::vector<int64_t> blocks;
  if (!occupancy) {
    blocks.resize(static_cast<size_t>(layout.blockCount()));
    for (size_t i = 0; i < blocks.size(); ++i) blocks[i] = static_cast<int64_t>(i);
    return blocks;
  }
  // A bit for each block of the volume, which drops repeats at no cost. Too many blocks have no
  // room for that.
  if (layout.blockCount() <= NumberSet::kMostNumbers) {
    NumberSet found(layout.blockCount());
    eachRow(layout, occupancy->boxes, [&](int64_t first, int64_t end) { found.add(first, end); });
    return found.numbers();
  }
  const auto dropRepeats = [&blocks] {
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  };
  size_t drop_at = size_t{1} << 22;
  eachRow(layout, occupancy->boxes, [&](int64_t first, int64_t end) {
    for (int64_t block = first; block < end; ++block) blocks.push_back(block);
    // Leaves of sparse formats repeat blocks many times over.
    if (blocks.size() > drop_at) {
      dropRepeats();
      // Twice the remaining number, so that sorting takes constant time a block in the mean.
      drop_at = std::max(drop_at, 2 * blocks.size());
    }
  });
  dropRepeats();
  return blocks;
}

std::vector<PassPiece> runsOf(const BlockLayout& layout, const std::vector<int64_t>& blocks,
                              int64_t most) {
  std::vector<Box3> runs;  // of block indices
  for (const int64_t block : blocks) {
    const Vec3i index = layout.indexOf(block);
    Box3* last = runs.empty() ? nullptr : &runs.back();
    const bool joins = last != nullptr && last->size().x < most && last->hi.x == index.x &&
                       last->lo.y == index.y && last->lo.z == index.z;
    if (joins)
      ++last->hi.x;
    else
      runs.push_back({index, index + Vec3i{1, 1, 1}});
  }
  std::vector<PassPiece> pieces;
  pieces.reserve(runs.size());
  for (const Box3& run : runs) {
    const Vec3i last = run.hi - Vec3i{1, 1, 1};
    PassPiece piece{unite(layout.ownedVoxels(run.lo), layout.ownedVoxels(last)), {}, run};
    piece.own = piece.read;
    // The last planes are the next blocks' first.
    for (int a = 0; a < 3; ++a) piece.own.hi[a] -= run.hi[a] < layout.grid[a] ? 1 : 0;
    pieces.push_back(piece);
  }
  return pieces;
}

namespace {

// Whether one of `blocks` (ascending) lies in a box of indices. One search a row is enough: if the
// first block at or behind the row's start is not in the row, none is.
bool holdsAny(const BlockLayout& layout, const std::vector<int64_t>& blocks, const Box3& box) {
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const auto first =
          std::lower_bound(blocks.begin(), blocks.end(), layout.idOf({box.lo.x, y, z}));
      if (first != blocks.end() && *first <= layout.idOf({box.hi.x - 1, y, z})) return true;
    }
  return false;
}

}  // namespace

std::vector<PassPiece> tilesOf(const BlockLayout& layout, const std::vector<int64_t>& blocks,
                               int64_t side, int64_t z, int64_t most_voxels) {
  const Vec3i dims = layout.dims;
  const int64_t columns = std::max<int64_t>(1, most_voxels / (side * side * side)) * side;
  std::vector<PassPiece> pieces;
  if (z >= dims.z) return pieces;
  for (int64_t y = 0; y < dims.y; y += side)
    for (int64_t x = 0; x < dims.x; x += columns) {
      PassPiece piece;
      piece.own = intersect({{x, y, z}, {x + columns, y + side, z + side}}, boxOf(dims));
      piece.read = piece.own;
      // Changes are counted from each voxel to the next along x, across the tiles, too.
      if (piece.own.hi.x < dims.x) ++piece.read.hi.x;
      piece.blocks = blocksAround(layout, piece.own);
      if (holdsAny(layout, blocks, piece.blocks)) pieces.push_back(piece);
    }
  return pieces;
}

}  // namespace sluice
