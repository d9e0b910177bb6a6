// LevelFades: the shares of translucent surfaces that blocks of two levels of resolution draw where
// they meet (LevelFade). In the cells of the finer block next to the face, its own share falls from
// 1 to 0 towards the coarser block, which draws the rest there from its ghost layers. If several
// faces of a block are seams, each takes its part of what those before it leave, so that the shares
// add up to 1 everywhere.
//
// Plain values. The seams that it is made of must outlive it.
#pragma once

#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/render/frame/level_borders.h"

namespace sluice {

class LevelFades {
 public:
  LevelFades() = default;
  explicit LevelFades(std::span<const LevelSeam> seams);

  // The shares within a block; unset: it draws all.
  std::optional<LevelFade> within(const BlockName& block) const;
  // Adds the boxes in finer blocks in which a block draws the rest. `box`: the block's.
  void addBorders(const BlockName& block, const BoxDraw& box, const Box3& shown,
                  const EyePosition& eye, LevelBorders& borders) const;

 private:
  std::span<const LevelSeam> seamsOf(const BlockName& fine) const;

  std::span<const LevelSeam> seams_;
  std::unordered_map<BlockName, std::vector<size_t>, BlockNameHash> of_coarse_;
};

}  // namespace sluice
