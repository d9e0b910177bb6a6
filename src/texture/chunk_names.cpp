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

ChunkNameList ChunkNames::namesOf(const TexturePlan& plan) {
  ChunkNameList names;
  names.reserve(plan.chunks.size());
  Recipe recipe;
  for (const Chunk& chunk : plan.chunks) {
    recipe.clear();
    for (const BlockPosition position : chunk.blocks) {
      const TextureBlock& block = plan.blocks[position];
      // All that the texels follow from, and nothing else: chunks of other thresholds keep their
      // names if their bytes are the same.
      const int axis = block.trimming_axis;
      for (const int64_t number :
           {block.name.time, int64_t{block.name.level}, int64_t{block.name.channel},
            block.name.block, int64_t{axis}, block.voxels.lo[axis], block.voxels.hi[axis],
            block.at.x, block.at.y, block.at.z})
        recipe.push_back(number);
    }
    for (size_t a = 0; a < plan.planes.size(); ++a)
      if (plan.planes[a]) recipe.insert(recipe.end(), {static_cast<int64_t>(a), *plan.planes[a]});
    const auto [known, is_new] = names_.emplace(recipe, ChunkName(count_));
    count_ += is_new ? 1 : 0;
    names.push_back(known->second);
  }
  return names;
}

}  // namespace sluice
