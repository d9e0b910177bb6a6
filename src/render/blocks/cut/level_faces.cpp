#include "src/render/blocks/cut/level_faces.h"

#include <algorithm>
#include <cmath>
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

std::vector<LevelSeam> takeLevelSeams(const PyramidLayout& pyramid, const Box3& crop,
                                      const std::function<bool(const BlockName&)>& is_in_picture,
                                      std::vector<ObjectBlock>& blocks) {
  Positions positions;
  positions.reserve(blocks.size());
  for (size_t i = 0; i < blocks.size(); ++i) positions.emplace(blocks[i].name, i);
  std::vector<LevelSeam> seams;
  // Finer blocks come first: a block is as large as it gets before its own seams are looked for.
  for (const ObjectBlock& block : blocks)
    for (int face = 0; face < 6; ++face) {
      if ((block.level_faces >> face & 1U) == 0) continue;
      const int axis = face % 3;
      const bool is_upper = face >= 3;
      const Box3 region = pyramid.regionOf(block.name);
      const int64_t plane = is_upper ? region.hi[axis] : region.lo[axis];
      // The cells next to the face on its other side.
      Box3 beyond = block.cells;
      beyond.lo[axis] = is_upper ? plane : plane - 1;
      beyond.hi[axis] = beyond.lo[axis] + 1;
      if (intersect(beyond, crop) != beyond) continue;
      const auto position = coarserAt(pyramid, positions, block.name, beyond.lo);
      if (!position || !is_in_picture(blocks[*position].name)) continue;
      ObjectBlock& coarse = blocks[*position];
      const int64_t reach =
          std::min(reachOf(pyramid, coarse.name, axis, is_upper, plane), region.size()[axis]);
      Box3 seam = block.cells;
      if (is_upper)
        seam.lo[axis] = plane - reach, seam.hi[axis] = plane;
      else
        seam.lo[axis] = plane, seam.hi[axis] = plane + reach;
      if (intersect(seam, block.cells).empty()) continue;
      coarse.cells = unite(coarse.cells, beyond);
      coarse.trimming_axis = shortestAxis(coarse.cells.size());
      seams.push_back({block.name, coarse.name, seam, face});
    }
  return seams;
}

}  // namespace sluice
