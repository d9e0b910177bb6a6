#include "src/render/blocks/visible_boxes.h"

#include <optional>

namespace sluice {
namespace {

// In samples that show nothing: the cost per ray of finding its slices of a box and blending the
// result, and the cost per box without rays. Of several pairs, this took least time on software GL
// for bonsai at threshold 40 and engine at 80, lit and unlit.
constexpr double kSamplesARay = 6, kSamplesABox = 400;

}  // namespace

BoxCost boxCost(double slices_a_cell) {
  return {kSamplesARay / slices_a_cell, kSamplesABox / slices_a_cell};
}

// Part of the tree that shows something.
struct VisibleBoxes::Part {
  int32_t at = 0;  // a node, or a box as ~position
  Box3 hull;       // hull of its visible cells
  double cost = 0;
};

class VisibleBoxes::Maker {
 public:
  Maker(VisibleBoxes& to, const BoxTree& tree, const BoxVisibility& visibility, const Box3& clip,
        const BoxCost& cost)
      : to_(to), tree_(tree), visibility_(visibility), clip_(clip), cost_(cost) {}

  // nullopt if nothing shows.
  std::optional<Part> make(int32_t at) {
    const TreeNode& node = tree_.nodes[static_cast<size_t>(at)];
    if (node.isLeaf()) return leaf(tree_.boxes[static_cast<size_t>(node.box)]);
    // If one box is cheaper than the parts, nodes and boxes are cut back to these lengths.
    const size_t nodes = to_.nodes_.size(), boxes = to_.boxes_.size();
    const std::optional<Part> lower = make(node.lower), upper = make(node.upper);
    if (!lower) return upper;
    if (!upper) return lower;
    const Box3 hull = unite(lower->hull, upper->hull);
    const double apart = lower->cost + upper->cost;
    // Both parts' boxes are dropped, and their hull is drawn instead: it has more cells and fewer
    // rays to set up.
    if (cost_.of(hull) <= apart) {
      to_.nodes_.resize(nodes);
      to_.boxes_.resize(boxes);
      return box(hull);
    }
    to_.nodes_.push_back({lower->at, upper->at, node.plane, node.axis});
    return Part{static_cast<int32_t>(to_.nodes_.size()) - 1, hull, apart};
  }

 private:
  std::optional<Part> leaf(const GrownBox& grown) {
    if (!visibility_.shows(grown.range)) return std::nullopt;
    const Box3 cells = intersect(grown.local(), clip_);
    if (cells.empty()) return std::nullopt;
    return box(cells);
  }
  Part box(const Box3& cells) {
    Cells drawn;
    for (int a = 0; a < 3; ++a) {
      // Cells of a block take 16 bits, since the boxes of a whole picture are kept.
      drawn.lo[static_cast<size_t>(a)] = static_cast<uint16_t>(cells.lo[a]);
      drawn.hi[static_cast<size_t>(a)] = static_cast<uint16_t>(cells.hi[a]);
    }
    to_.boxes_.push_back(drawn);
    // A complement marks a box, so that a position and its kind fit one number.
    return {~(static_cast<int32_t>(to_.boxes_.size()) - 1), cells, cost_.of(cells)};
  }

  VisibleBoxes& to_;
  const BoxTree& tree_;
  const BoxVisibility& visibility_;
  const Box3& clip_;
  const BoxCost& cost_;
};

VisibleBoxes::VisibleBoxes(const BoxTree& tree, const BoxVisibility& visibility, const Box3& clip,
                           const BoxCost& cost) {
  Maker(*this, tree, visibility, clip, cost).make(0);
  for (const Cells& box : boxes_) {
    int64_t cells = 1;
    for (size_t a = 0; a < 3; ++a) cells *= box.hi[a] - box.lo[a];
    cell_count_ += cells;
  }
  nodes_.shrink_to_fit();
  boxes_.shrink_to_fit();
}

}  // namespace sluice
