#include "src/texture/chunk_names.h"

namespace sluice {

size_t ChunkNames::Hash::operator()(const Recipe& recipe) const {
  uint64_t hash = recipe.size();
  for (const int64_t number : recipe) {
    hash = (hash ^ static_cast<uint64_t>(number)) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 29;
  }
  return static_cast<size_t>(hash);
}

std::vector<uint64_t> ChunkNames::namesOf(const TexturePlan& plan) {
  std::vector<uint64_t> names;
  names.reserve(plan.chunks.size());
  Recipe recipe;
  for (const Chunk& chunk : plan.chunks) {
    recipe.assign({plan.time});
    for (const int64_t position : chunk.blocks) {
      const TextureBlock& block = plan.blocks[static_cast<size_t>(position)];
      const int axis = block.trimming_axis;
      for (const int64_t number : {block.block, int64_t{axis}, block.voxels.lo[axis],
                                   block.voxels.hi[axis], block.at.x, block.at.y, block.at.z})
        recipe.push_back(number);
    }
    names.push_back(names_.emplace(recipe, names_.size()).first->second);
  }
  return names;
}

}  // namespace sluice
