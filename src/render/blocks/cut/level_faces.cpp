#include "src/render/blocks/cut/level_faces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <unordered_set>

namespace sluice {
namespace {

// Rounding of scales and offsets that files give as decimals, in voxels.
constexpr double kCellRounding = 1e-6;

using Positions = std::unordered_map<BlockName, size_t, BlockNameHash>;

// The position of the drawn block of a coarser level than `fine` that holds a cell.
std::optional<size_t> coarserAt(const PyramidLayout& pyramid, const Positions& positions,
                                const BlockName& fine, Vec3i cell) {
  for (int number = fine.level + 1; number < pyramid.levels(); ++number) {
    const LevelLayout& level = pyramid.level(number);
    BlockName name = fine;
    name.level = number;
    name.block = level.blocks.idOf(min(cell / level.width, level.blocks.grid - Vec3i{1, 1, 1}));
    if (const auto found = positions.find(name); found != positions.end()) return found->second;
  }
  return std::nullopt;
}

// How many cells below or above a plane the texels of a coarse block reach whose cells end there.
int64_t reachOf(const PyramidLayout& pyramid, const BlockName& coarse, int axis, bool below,
                int64_t plane) {
  const LevelLayout& level = pyramid.of(coarse);
  const Box3 stored = pyramid.storedVoxels(coarse);
  Box3 at{{plane, plane, plane}, {plane, plane, plane}};
  const Box3 needed = level.voxelsUnder(at);
  const int64_t ghost = level.blocks.ghost;
  const auto most = static_cast<int64_t>(std::ceil(level.placement.scale[axis] - kCellRounding));
  Vec3i texel;
  texel[axis] = below ? std::max(stored.lo[axis], needed.lo[axis] - ghost)
                      : std::min(stored.hi[axis], needed.hi[axis] + ghost) - 1;
  const double end = level.placement.finestFromLevel(toDouble(texel))[axis];
  const double cells = below ? static_cast<double>(plane) - end : end - static_cast<double>(plane);
  return std::clamp<int64_t>(static_cast<int64_t>(std::floor(cells + kCellRounding)), 0, most);
}

// The faces of a block, then its edges, then its corners, each by the faces that it lies on.
constexpr std::array kSides = [] {
  std::array<unsigned, 26> sides{};
  size_t next = 0;
  for (int count = 1; count <= 3; ++count)
    for (unsigned faces = 1; faces < 64; ++faces)
      // None lies on opposite faces.
      if (std::popcount(faces) == count && (faces & faces >> 3) == 0) sides[next++] = faces;
  return sides;
}();

// The planes of faces of a block that meet at a side of it, and its cells beyond them.
struct BlockSide {
  unsigned faces;
  Box3 region;  // of the block
  Box3 beyond;  // the cells next to those of `cells`

  BlockSide(unsigned of, const Box3& block_region, const Box3& cells)
      : faces(of), region(block_region), beyond(cells) {
    visit([&](int axis, bool is_upper, int64_t plane) {
      beyond.lo[axis] = is_upper ? plane : plane - 1;
      beyond.hi[axis] = beyond.lo[axis] + 1;
    });
  }
  // visit(axis, whether it is the upper face across it, the plane of the face)
  void visit(const auto& at) const {
    for (int face = 0; face < 6; ++face)
      if ((faces >> face & 1U) != 0)
        at(face % 3, face >= 3, face >= 3 ? region.hi[face % 3] : region.lo[face % 3]);
  }
};

// Whether a block of the next coarser level beyond an edge or a corner touches the block there
// alone: one that holds the block, or meets it at a face, has it in its range along an axis.
bool leavesParent(const PyramidLayout& pyramid, const BlockName& fine, const BlockSide& side) {
  if (fine.level + 1 >= pyramid.levels()) return false;
  const Vec3i width = pyramid.level(fine.level + 1).width;
  bool leaves = true;
  side.visit([&](int axis, bool, int64_t) {
    leaves = leaves && side.beyond.lo[axis] / width[axis] != side.region.lo[axis] / width[axis];
  });
  return leaves;
}

// The cells of a block that the coarser block's texels reach beyond a side of it.
Box3 seamCells(const PyramidLayout& pyramid, const BlockName& coarse, const BlockSide& side,
               Box3 cells) {
  side.visit([&](int axis, bool is_upper, int64_t plane) {
    const int64_t reach =
        std::min(reachOf(pyramid, coarse, axis, is_upper, plane), side.region.size()[axis]);
    cells.lo[axis] = is_upper ? plane - reach : plane;
    cells.hi[axis] = is_upper ? plane : plane + reach;
  });
  return cells;
}

}  // namespace

void setLevelFaces(const PyramidLayout& pyramid, std::vector<ObjectBlock>& blocks) {
  std::unordered_set<BlockName, BlockNameHash> drawn;
  drawn.reserve(blocks.size());
  for (const ObjectBlock& block : blocks) drawn.insert(block.name);
  for (ObjectBlock& block : blocks) {
    const BlockLayout& layout = pyramid.of(block.name).blocks;
    const Vec3i index = layout.indexOf(block.name.block);
    for (int a = 0; a < 3; ++a)
      for (const int64_t way : {-1, 1}) {
        Vec3i next = index;
        next[a] += way;
        if (next[a] < 0 || next[a] >= layout.grid[a]) continue;
        BlockName name = block.name;
        name.block = layout.idOf(next);
        if (!drawn.contains(name)) block.level_faces |= 1U << (way < 0 ? a : 3 + a);
      }
  }
}

std::vector<LevelSeam> takeLevelSeams(const PyramidLayout& pyramid, const SeamQuestion& question,
                                      std::vector<ObjectBlock>& blocks) {
  Positions positions;
  positions.reserve(blocks.size());
  for (size_t i = 0; i < blocks.size(); ++i) positions.emplace(blocks[i].name, i);
  std::vector<LevelSeam> seams;
  // Finer blocks come first: a block is as large as it gets before its own seams are looked for.
  for (const ObjectBlock& block : blocks) {
    const size_t first = seams.size();
    const Box3 region = pyramid.regionOf(block.name);
    const auto meets = [&](const BlockName& coarse) {
      return std::ranges::find(seams.begin() + static_cast<std::ptrdiff_t>(first), seams.end(),
                               coarse, &LevelSeam::coarse) != seams.end();
    };
    for (const unsigned faces : kSides) {
      const bool is_face = std::has_single_bit(faces);
      if (!is_face && !question.with_edges) break;
      if (is_face && (block.level_faces & faces) == 0) continue;
      const BlockSide side(faces, region, block.cells);
      if (intersect(side.beyond, question.crop) != side.beyond) continue;
      if (!is_face && !leavesParent(pyramid, block.name, side)) continue;
      const auto position = coarserAt(pyramid, positions, block.name, side.beyond.lo);
      if (!position) continue;
      ObjectBlock& coarse = blocks[*position];
      if (!question.is_in_picture(coarse.name) || (!is_face && meets(coarse.name))) continue;
      const Box3 cells = seamCells(pyramid, coarse.name, side, block.cells);
      if (intersect(cells, block.cells).empty()) continue;
      coarse.cells = unite(coarse.cells, side.beyond);
      coarse.trimming_axis = shortestAxis(coarse.cells.size());
      seams.push_back({block.name, coarse.name, cells, faces});
    }
  }
  return seams;
}

}  // namespace sluice
