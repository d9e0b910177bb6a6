// BoxTree: the grown boxes of a block as an orthogonal BSP tree (Li 2003, section 3.2), which puts
// them in visibility order for any eye, even if they overlap in a circle.
//
// Each node halves its room with a plane that the faces of at least two boxes share, the one that
// cuts fewest boxes; a leaf is one box, and its box is its room. A cut box becomes the parent of
// its pieces: one level only, and the pieces draw from the parent's texture instead of storing
// their shared texels twice. Then sibling leaves are merged bottom-up by the paper's three rules;
// if pieces of different parents merge, those parents are given up and all their pieces stand
// alone.
//
// The paper merges two gradient or two other boxes, and thin ones, whatever they hold. Here the
// merged box must also keep the cost limits of growing_boxes.h (thin ones a wider one), since
// otherwise siblings merge up to boxes that show everything. Pieces of one parent always merge
// back.
//
// Plain arrays, a pure function of bricks and boxes. Immutable once built; any thread may read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/error.h"
#include "src/classify/boxes/growing_boxes.h"

namespace sluice {

struct TreeNode {
  int32_t lower = -1, upper = -1;  // children, on either side of the plane; -1 in a leaf
  int32_t box = -1;                // a leaf's index in BoxTree::boxes
  uint16_t plane = 0;              // between cells, relative to the block's first
  uint8_t axis = 0;

  bool isLeaf() const { return box >= 0; }
  friend bool operator==(const TreeNode&, const TreeNode&) = default;
};

struct BoxTree {
  std::vector<TreeNode> nodes;  // the root first, a node before its children
  std::vector<GrownBox>
      boxes;  // boxes of the leaves, from lower to upper: disjoint, no cell left out
  std::vector<GrownBox> textures;  // boxes whose voxels are stored: parents, and boxes without one
  std::vector<uint32_t> texture_of;  // for each box, the texture that holds it
  uint32_t grown = 0;                // how many boxes there were before

  uint64_t bytes() const {
    return nodes.size() * sizeof(TreeNode) + (boxes.size() + textures.size()) * sizeof(GrownBox) +
           texture_of.size() * sizeof(uint32_t);
  }
  friend bool operator==(const BoxTree&, const BoxTree&) = default;
};

// No tree is deeper: each level halves a room between bricks.
inline constexpr size_t kMostTreeDepth = 3 * kMostBricks;

// Requires: `boxes` are disjoint unions of the grid's bricks that cover all its cells.
BoxTree boxTree(const BrickGrid& grid, std::span<const GrownBox> boxes,
                const GrowingParameters& parameters);
// The whole way of a block: grown boxes, converted.
BoxTree growBoxTree(const BrickGrid& grid, const GrowingParameters& parameters);

// The eye of the picture, in cells relative to the block's first owned cell.
struct BoxEye {
  bool parallel = true;
  Vec3d at;  // parallel: the viewing direction; otherwise the eye
};

}  // namespace sluice
