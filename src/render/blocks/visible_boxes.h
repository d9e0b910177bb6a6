// VisibleBoxes: the growing boxes of one block that are drawn under one transfer function (Li 2003,
// section 3): the visible ones, cut to the block's texture, as a BSP tree of their own.
//
// A tree of all boxes (box_tree.h) knows no transfer function. Here each of its boxes turns out
// visible or skipped, and sides of a plane that show nothing are left out. A part of the tree is
// drawn as one box, the smallest around its visible ones, if that is cheaper than drawing them one
// by one: the skipped cells that it draws in vain cost less than beginning a box for each ray.
// Every visible cell is in exactly one box, so the picture does not depend on the choice.
//
// Immutable once made; any thread may read. Positions are cells relative to the block's first owned
// cell throughout.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/classify/boxes/box_tree.h"
#include "src/classify/boxes/box_visibility.h"

namespace sluice {

// The cost of drawing a box in addition to its cells, in cells: one part for each ray that meets
// it, in proportion to its shadow, and one for the box itself.
struct BoxCost {
  double a_shadow = 0;  // for each cell face of the shadow, the mean over all views
  double a_box = 0;

  double of(const Box3& box) const {
    const Vec3d size = toDouble(box.size());
    // A convex body's mean shadow is a quarter of its surface.
    const double shadow = 0.5 * (size.x * size.y + size.y * size.z + size.z * size.x);
    return size.x * size.y * size.z + a_shadow * shadow + a_box;
  }
};
// `slices_a_cell`: how many samples a ray takes in a cell. They cost the same lit and unlit, since
// samples that show nothing are not lit.
BoxCost boxCost(double slices_a_cell);

class VisibleBoxes {
 public:
  // `clip`: the cells that may be drawn. Requires: tree.nodes not empty, clip not empty.
  VisibleBoxes(const BoxTree& tree, const BoxVisibility& visibility, const Box3& clip,
               const BoxCost& cost);

  size_t count() const { return boxes_.size(); }
  int64_t cells() const { return cell_count_; }  // in all boxes
  uint64_t bytes() const {
    return sizeof(*this) + nodes_.capacity() * sizeof(Node) + boxes_.capacity() * sizeof(Cells);
  }

  // Calls visit(const Box3&) for each box, those in front of others first.
  template <class Visit>
  void visitFrontToBack(const BoxEye& eye, Visit&& visit) const;

 private:
  // A plane between boxes. Children: nodes, or boxes as ~position.
  struct Node {
    int32_t lower = 0, upper = 0;
    uint16_t plane = 0;
    uint8_t axis = 0;
  };
  struct Cells {
    std::array<uint16_t, 3> lo{}, hi{};
  };
  struct Part;
  class Maker;

  std::vector<Node> nodes_;  // children before their parent, the root last
  std::vector<Cells> boxes_;
  int64_t cell_count_ = 0;
};

template <class Visit>
void VisibleBoxes::visitFrontToBack(const BoxEye& eye, Visit&& visit) const {
  if (boxes_.empty()) return;
  std::array<int32_t, kMostTreeDepth + 1> waiting;
  size_t count = 0;
  waiting[count++] = nodes_.empty() ? ~0 : static_cast<int32_t>(nodes_.size()) - 1;
  while (count > 0) {
    int32_t at = waiting[--count];
    while (at >= 0) {
      const Node& node = nodes_[static_cast<size_t>(at)];
      const double eye_at = eye.at[node.axis];
      const bool lower_first = eye.parallel ? eye_at > 0 : eye_at < static_cast<double>(node.plane);
      waiting[count++] = lower_first ? node.upper : node.lower;
      at = lower_first ? node.lower : node.upper;
    }
    const Cells& box = boxes_[static_cast<size_t>(-(int64_t{at} + 1))];
    visit(Box3{{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}});
  }
}

}  // namespace sluice
