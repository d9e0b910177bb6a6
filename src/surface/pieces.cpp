#include "src/surface/pieces.h"

#include <algorithm>

namespace sluice {

Piece PieceGrid::piece(int64_t id) const {
  Piece piece;
  piece.index = {id % size_.x, id / size_.x % size_.y, id / (size_.x * size_.y)};
  const Vec3i first{piece.index.x * row_blocks_, piece.index.y, piece.index.z};
  piece.blocks = {first,
                  {std::min(first.x + row_blocks_, layout_.grid.x), first.y + 1, first.z + 1}};
  const Box3 owned = {layout_.ownedCells(piece.blocks.lo).lo,
                      layout_.ownedCells(piece.blocks.hi - Vec3i{1, 1, 1}).hi};
  piece.cells = intersect(owned, region_.cells);
  const int64_t layer = region_.is_closed ? 1 : 0;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    piece.has_before[axis] = piece.cells.lo[a] > region_.cells.lo[a];
    piece.has_behind[axis] = piece.cells.hi[a] < region_.cells.hi[a];
  }
  if (piece.cells.empty()) return piece;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    if (!piece.has_before[axis]) piece.cells.lo[a] -= layer;
    if (!piece.has_behind[axis]) piece.cells.hi[a] += layer;
  }
  return piece;
}

std::vector<int64_t> PieceGrid::mixedPieces(const BlockStates& states) const {
  std::vector<int64_t> ids;
  for (const BlockStates::Block& block : states.blocks) {
    if (block.state != RangeState::kMixed) continue;
    const Vec3i index = layout_.indexOf(block.id);
    if (intersect(layout_.ownedCells(index), region_.cells).empty()) continue;
    const int64_t id = idOf({index.x / row_blocks_, index.y, index.z});
    if (ids.empty() || ids.back() != id) ids.push_back(id);
  }
  // Blocks of two pieces alternate if these have several blocks along x.
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace sluice
