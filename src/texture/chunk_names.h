// ChunkNames: a number for each recipe of a chunk, so that a chunk whose recipe a new plan repeats
// keeps its bytes at levels 3 and 4 (design, point 1).
//
// A recipe is everything that the texels follow from: the time step, and of each texture block its
// volume block, the voxels copied, the turn and the place. Whole recipes are compared, not hashes
// of them. One thread.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "src/texture/texture_plan.h"

namespace sluice {

class ChunkNames {
 public:
  // The names of plan.chunks, in that order. Equal recipes have equal names over all plans of one
  // layout and page geometry.
  std::vector<uint64_t> namesOf(const TexturePlan& plan);
  // Names run from 0 up to this.
  uint64_t count() const { return names_.size(); }

 private:
  using Recipe = std::vector<int64_t>;
  struct Hash {
    size_t operator()(const Recipe& recipe) const;
  };
  std::unordered_map<Recipe, uint64_t, Hash> names_;
};

}  // namespace sluice
