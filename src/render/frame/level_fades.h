// LevelFades: the shares of translucent surfaces that blocks of two levels of resolution draw where
// they meet (LevelFade). In the cells of the finer block next to the face, its own share falls from
// 1 to 0 towards the coarser block, which draws the rest there from its ghost layers. If several
// faces of a block are seams, each takes its part of what those before it leave, so that the shares
// add up to 1 everywhere.
//
// The rest is drawn together with the finer block, slice by slice: what else that block shows lies
// in front of the surface in one slice and behind it in the next.
//
// Plain values. The seams that it is made of must outlive it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/render/frame/level_borders.h"

namespace sluice {

class LevelFades {
 public:
  LevelFades() = default;
  explicit LevelFades(std::span<const LevelSeam> seams) : seams_(seams) {}

  const LevelSeam& seam(size_t number) const { return seams_[number]; }
  // The shares within a block; unset: it draws all.
  std::optional<LevelFade> within(const BlockName& block) const;
  // The shares of the coarser block of a seam.
  LevelFade rest(const LevelSeam& seam) const;

 private:
  std::span<const LevelSeam> seamsOf(const BlockName& fine) const;

  std::span<const LevelSeam> seams_;
};

// The boxes that draw the coarser block's share at a seam.
struct SeamBoxes {
  std::optional<BoxDraw> joined;  // in the cells of the finer block's box
  std::optional<BoxDraw> beyond;  // from there to the face, where the finer block shows nothing
  bool is_before = false;         // rays pass `beyond` before the finer block's box
};
// `coarse`: the coarser block's texels, as a box. `fine`: the box that it joins. `shown`: cells
// that may show.
SeamBoxes seamBoxes(const LevelSeam& seam, BoxDraw coarse, const Box3& fine, const Box3& shown,
                    const EyePosition& eye);

// A part of a box that each seam's cells fill or do not meet.
struct SeamPart {
  Box3 cells;
  std::vector<size_t> seams;  // those that fill it, by their positions
};
// Cuts a box at the cells of its seams: parts front to back.
std::vector<SeamPart> partsAtSeams(const Box3& cells, std::span<const Box3> seams,
                                   const EyePosition& eye);

}  // namespace sluice
