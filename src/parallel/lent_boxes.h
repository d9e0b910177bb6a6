// LentBoxes: a volume that ranks have in parts already, such as a simulation's: each rank draws the
// box that it lends, and nothing of the voxels moves from rank to rank.
//
// The boxes tile the volume, and planes along the axes part them again and again (a k-d tree), as
// regular grids, slabs and recursive bisections do. So there is an order of the boxes for each view
// in which none hides an earlier one. Plain values and pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/values/vec.h"
#include "src/device/frame_values.h"

namespace sluice {

class LentBoxes {
 public:
  // The voxels that each rank lends, without those that it shares with others. Throws Error, which
  // begins with `name`: a box is empty or reaches out of `dims`; they overlap, leave out voxels or
  // cannot be parted by planes.
  LentBoxes(std::vector<Box3> boxes, Vec3i dims, const std::string& name);

  int count() const { return static_cast<int>(boxes_.size()); }
  // The cells of the volume that a rank draws: those that begin in its box. Cell i lies between the
  // voxels i and i + 1. May be empty, of a box of the last voxels alone.
  Box3 cellsOf(int rank) const;
  // The voxels that a rank needs to draw its cells; `around`: with those beside them, for
  // gradients.
  Box3 voxelsFor(int rank, bool around) const;
  // The rank that has a cell.
  int rankAt(Vec3i cell) const;
  // The place of each rank in the order from the eye, the nearest first: 0 and on.
  std::vector<uint32_t> layersFor(const FrameSetup& setup) const;

 private:
  // A plane through the first voxels of the upper part, or a box.
  struct Node {
    int axis = 0;
    int64_t plane = 0;
    int below = -1, above = -1;  // further nodes; -1: this is a box
    int rank = 0;                // of a box
  };
  // Parts the boxes of these ranks, and returns the node.
  int part(std::vector<int> ranks, const std::string& name);

  Vec3i dims_;
  std::vector<Box3> boxes_;
  std::vector<Node> nodes_;
  int root_ = 0;
};

}  // namespace sluice
