// The visiting order of a whole tree of boxes. Frames visit the chosen boxes alone
// (src/render/blocks/visible_boxes.h).
#pragma once

#include <array>
#include <cstdint>

#include "src/classify/boxes/box_tree.h"

namespace sluice {

// Calls visit(position in tree.boxes) for each box, those in front of others first. Allocates
// nothing. Requires: tree.nodes not empty.
template <class Visit>
void visitFrontToBack(const BoxTree& tree, const BoxEye& eye, Visit&& visit) {
  std::array<int32_t, kMostTreeDepth + 1> waiting;
  size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const TreeNode* node = &tree.nodes[static_cast<size_t>(waiting[--count])];
    while (!node->isLeaf()) {
      const double at = eye.at[node->axis];
      const bool lower_first = eye.parallel ? at > 0 : at < static_cast<double>(node->plane);
      waiting[count++] = lower_first ? node->upper : node->lower;
      node = &tree.nodes[static_cast<size_t>(lower_first ? node->lower : node->upper)];
    }
    visit(static_cast<size_t>(node->box));
  }
}

}  // namespace sluice
