#include "src/render/blocks/cut/level_faces.h"

#include <unordered_set>

namespace sluice {

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

}  // namespace sluice
