// LevelFades: the shares of surfaces that blocks of two levels of resolution draw where they meet
// (LevelFade). In the cells of the finer block next to the face, its own share falls from 1 to 0
// towards the coarser block, which draws the rest there from its ghost layers. If several faces of
// a block are seams, each takes its part of what those before it leave, so that the shares add up
// to 1 everywhere. Opaque surfaces are drawn in full by both, for rays end at the first one, and by
// blocks that meet at an edge or a corner alone.
//
// The rest is drawn together with the finer block, slice by slice: what else that block shows lies
// in front of the surface in one slice and behind it in the next.
//
// The seams that it is made of must outlive it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/device/frame_values.h"
#include "src/texture/texture_plan.h"

namespace sluice {

class LevelFades {
 public:
  LevelFades() = default;
  // `seams`: as VisibleBlocks has them.
  explicit LevelFades(std::span<const LevelSeam> seams);

  const LevelSeam& seam(size_t number) const { return seams_[number]; }
  // The shares within a block; unset: it draws all.
  std::optional<LevelFade> within(const BlockName& block) const;
  // The shares of the coarser block of a seam.
  LevelFade rest(const LevelSeam& seam) const;

  bool hasSeamAt(const BlockName& fine, int face) const;
  // The cells of the seams with finer blocks, in which a block draws surfaces.
  std::vector<Box3> cellsInFiner(const BlockName& coarse) const;

 private:
  std::span<const LevelSeam> seamsOf(const BlockName& fine) const;

  std::span<const LevelSeam> seams_;
  std::vector<uint32_t> by_coarser_;  // positions of seams
};

// Whether rays pass what lies below a plane across the axis before what lies above it.
bool passesLowerFirst(const EyePosition& eye, int axis, int64_t plane);

// The boxes that draw the coarser block's share at a seam.
struct SeamBoxes {
  std::optional<BoxDraw> joined;  // in the cells of the finer block's box
  // In cells in which the finer block shows nothing: rays pass these before its box, or behind it.
  std::vector<BoxDraw> before, behind;
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
