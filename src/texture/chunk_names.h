// ChunkNames: a number for each recipe of a chunk, so that a chunk whose recipe a new plan repeats
// keeps its bytes at levels 3 and 4 (design, point 1).
//
// A recipe holds everything that the texels follow from: for each texture block the volume block,
// the voxels copied, the turn and the place; and the planes that all others repeat. Whole recipes
// are compared, not hashes of them. One thread.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "src/texture/texture_plan.h"

namespace sluice {

class ChunkNames {
 public:
  // The first name that is given: 0, or the count() of names that a trace has already.
  explicit ChunkNames(int64_t first = 0) : count_(first) {}

  // The names of plan.chunks, in that order. Equal recipes have equal names over all plans of one
  // layout and page geometry.
  ChunkNameList namesOf(const TexturePlan& plan);
  // Names run from the first one up to this; none is given twice.
  int64_t count() const { return count_; }
  // Recipes whose names are known. forgetUnused() drops those whose name `is_used` denies: should
  // one come again it gets a new name.
  size_t kept() const { return names_.size(); }
  template <class IsUsed>
  void forgetUnused(IsUsed&& is_used) {
    std::erase_if(names_, [&](const auto& known) { return !is_used(known.second); });
  }

 private:
  using Recipe = std::vector<int64_t>;
  struct Hash {
    size_t operator()(const Recipe& recipe) const;
  };
  std::unordered_map<Recipe, ChunkName, Hash> names_;
  int64_t count_;
};

}  // namespace sluice
