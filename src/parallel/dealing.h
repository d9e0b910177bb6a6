// Dealing: which rank has which block of a volume (Gao 2004, section 6), and the order in which the
// ranks' parts lie along the rays.
//
// Cubes of blocks, hands, are dealt one by one along Hilbert's curve, each a golden section of the
// ranks further: any stretch of the curve is shared out evenly, and one that meets a part of the
// volume at regular places, as planes do, not always by the same ranks. So whatever part of the
// volume a picture shows, every rank has nearly as much of it as every other; it follows from the
// grid of blocks alone. A rank's blocks lie between others': along
// a ray theirs and its own take turns. Pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/values/vec.h"
#include "src/classify/blocks/classification.h"
#include "src/device/frame_values.h"
#include "src/parallel/lent_boxes.h"
#include "src/volume/pyramid.h"

namespace sluice {

// How the blocks of a volume are dealt to ranks. In a volume with levels of resolution, a block of
// a coarser level stands for the finest blocks in its region. Hands are made of whole regions, up
// to the level at which too few hands would be left for the ranks, or to one that is asked for.
struct Dealing {
  Vec3i hands;  // grid of hands, the unit of dealing; the last along an axis have the rest of it
  int ranks = 1;
  int64_t hand = 1;      // finest blocks a side of a hand
  int64_t side_vox = 1;  // finest cells a side of that
  int bits = 0;          // bits of the curve's coordinates
  // Each block of this level and of finer ones lies in one hand; pictures show no coarser blocks.
  int coarsest_level = 0;
  // The ranks draw the boxes that they have, and no block is dealt; null: blocks are dealt.
  std::shared_ptr<const LentBoxes> lent = nullptr;

  // The hand that a finest cell lies in.
  Vec3i handOf(Vec3i cell) const { return min(cell / side_vox, hands - Vec3i{1, 1, 1}); }
  // The rank of a finest block.
  int rankOf(Vec3i block) const;
};
// Deals the blocks of one picture: returns the rank of each block, by hands along the curve, each
// to the rank that has the fewest blocks so far. This balances better, since few blocks are seen at
// once, and differs from picture to picture: for series, in which every picture reads data that no
// other does.
std::vector<int32_t> dealPicture(const Dealing& dealing, const PyramidLayout& pyramid,
                                 const VisibleBlocks& visible);
// Larger hands, which fewer rays cross, if there are enough of them for every rank. `level`: hands
// hold whole blocks of this level, however few they are.
Dealing dealBlocks(const PyramidLayout& pyramid, int ranks, int level = 0);

// Ranks that draw the boxes that they lend.
Dealing dealLent(std::shared_ptr<const LentBoxes> boxes);

// The layers of a view (partial_picture.h): of each hand how many steps along the axes it lies from
// the eye. A ray that leads from one hand into another goes away from the eye along each axis, and
// along one at least by a step. So hands of a layer do not hide each other, and hands of later
// layers do not hide earlier ones. Lent boxes are a layer each, in their order.
class DealingLayers {
 public:
  DealingLayers(const Dealing& dealing, const FrameSetup& setup);
  // The layer of a box of cells that lie in one block.
  uint32_t layerOf(const Box3& cells) const;

 private:
  const Dealing dealing_;
  std::vector<uint32_t> of_ranks_;  // of lent boxes
  bool parallel_;
  Vec3i eye_;                   // perspective: the hand that it is in, or nearest to
  std::array<bool, 3> down_{};  // parallel: rays go down this axis
};

}  // namespace sluice
