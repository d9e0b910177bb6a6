#include "src/classify/boxes/box_tree.h"

#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>

namespace sluice {
namespace {

constexpr int32_t kNone = -1;
// Rule 3: a box of one brick along some axis is thin, and a box of at most so many bricks in all is
// tiny. Both join their sibling even if that costs this much more than a box may.
constexpr int64_t kTinyBricks = 2;
constexpr float kThinAllowance = 1.1F;

// A box or a piece of one, in bricks.
struct Piece {
  Box3 bricks;
  int32_t owner = kNone;  // the grown box that it is, or is a piece of; none after a merge
};

struct Split {
  int axis = 0;
  int64_t plane = 0;  // in bricks
  int64_t cut = 0, imbalance = 0;
};

// A subtree while it is built; a leaf has no children.
struct Built {
  Piece leaf;
  Split split;
  std::unique_ptr<Built> lower, upper;
};

class Converter {
 public:
  Converter(const BrickGrid& grid, std::span<const GrownBox> boxes,
            const GrowingParameters& parameters)
      : grid_(grid), parameters_(parameters), wide_(parameters), given_up_(boxes.size()) {
    wide_.cost_limit_cells *= kThinAllowance;
    wide_.mean_cost_limit = std::min(1.F, kThinAllowance * wide_.mean_cost_limit);
    for (const GrownBox& box : boxes)
      pieces_.push_back({grid.bricksOf(box.local()), static_cast<int32_t>(pieces_.size())});
    owned_ = pieces_;
  }

  BoxTree convert() {
    BoxTree tree;
    tree.grown = static_cast<uint32_t>(pieces_.size());
    const std::unique_ptr<Built> root = build({{0, 0, 0}, grid_.size}, std::move(pieces_));
    texture_of_owner_.assign(owned_.size(), kNone);
    flatten(*root, tree);
    return tree;
  }

 private:
  // The plane to split at: of all planes between bricks on which two faces lie, the one that cuts
  // fewest boxes; of equals, the one whose sides are most equal. The pieces fill the room, so a
  // face of one is a face of another, unless it is the room's.
  Split chooseSplit(const Box3& room, const std::vector<Piece>& pieces) {
    std::optional<Split> best;
    for (int axis = 0; axis < 3; ++axis) {
      begins_.assign(static_cast<size_t>(room.size()[axis]) + 1, 0);
      ends_.assign(begins_.size(), 0);
      for (const Piece& piece : pieces) {
        ++begins_[static_cast<size_t>(piece.bricks.lo[axis] - room.lo[axis])];
        ++ends_[static_cast<size_t>(piece.bricks.hi[axis] - room.lo[axis])];
      }
      int64_t begun = begins_[0], ended = 0;
      for (size_t at = 1; at + 1 < begins_.size(); ++at) {
        ended += ends_[at];
        const int64_t cut = begun - ended;
        const int64_t below = begun, above = static_cast<int64_t>(pieces.size()) - ended;
        begun += begins_[at];
        // Only planes that two faces share may split, so that as few boxes as possible are cut.
        if (begins_[at] + ends_[at] < 2) continue;
        const Split split{axis, room.lo[axis] + static_cast<int64_t>(at), cut,
                          std::abs(below - above)};
        // Few cuts first, then an even number on both sides.
        if (!best || std::pair(split.cut, split.imbalance) < std::pair(best->cut, best->imbalance))
          best = split;
      }
    }
    SLUICE_CHECK(best.has_value());
    return *best;
  }

  std::unique_ptr<Built> build(const Box3& room, std::vector<Piece> pieces) {
    auto built = std::make_unique<Built>();
    if (pieces.size() == 1) {
      built->leaf = pieces.front();
      SLUICE_CHECK(built->leaf.bricks == room);
      return built;
    }
    built->split = chooseSplit(room, pieces);
    const auto [axis, plane, cut, imbalance] = built->split;
    Box3 low_room = room, high_room = room;
    low_room.hi[axis] = high_room.lo[axis] = plane;
    std::vector<Piece> low, high;
    for (const Piece& piece : pieces) {
      const Box3 below = intersect(piece.bricks, low_room);
      const Box3 above = intersect(piece.bricks, high_room);
      if (!below.empty()) low.push_back({below, piece.owner});
      if (!above.empty()) high.push_back({above, piece.owner});
    }
    // Freed before the recursion, which may be deep.
    pieces = {};
    built->lower = build(low_room, std::move(low));
    built->upper = build(high_room, std::move(high));
    // Only two leaves merge: merging goes from the leaves up.
    if (!built->lower->lower && !built->upper->lower) tryMerge(room, *built);
    return built;
  }

  // Makes a leaf of a node of two leaves if a rule allows it.
  void tryMerge(const Box3& room, Built& node) {
    const Piece& a = node.lower->leaf;
    const Piece& b = node.upper->leaf;
    // Pieces of one box become the box again.
    if (a.owner != kNone && a.owner == b.owner) {
      node.leaf = {room, a.owner};
    } else if (mayMerge(room, a.bricks, b.bricks)) {
      // A merged piece belongs to no box, so that the other pieces of its parent stand alone, too.
      for (const int32_t owner : {a.owner, b.owner})
        if (owner != kNone) given_up_[static_cast<size_t>(owner)] = 1;
      node.leaf = {room, kNone};
    } else {
      return;
    }
    node.lower.reset();
    node.upper.reset();
  }

  bool mayMerge(const Box3& room, const Box3& a, const Box3& b) const {
    const BoxType type_a = boxOfBricks(grid_, a, parameters_).type;
    const BoxType type_b = boxOfBricks(grid_, b, parameters_).type;
    const GrownBox merged = boxOfBricks(grid_, room, parameters_);
    const bool alike =
        type_a == type_b && (type_a != BoxType::kUniform || merged.type == BoxType::kUniform);
    const bool thin = isThin(a) || isThin(b);
    if (!alike && !thin) return false;
    const double cost = costOf(grid_, room, merged.range, parameters_);
    return isWithinLimits(cost, merged.local().count(), thin ? wide_ : parameters_);
  }
  static bool isThin(const Box3& bricks) {
    const Vec3i size = bricks.size();
    return std::min({size.x, size.y, size.z}) <= 1 || bricks.count() <= kTinyBricks;
  }

  int32_t flatten(const Built& built, BoxTree& tree) {
    const auto at = static_cast<int32_t>(tree.nodes.size());
    tree.nodes.emplace_back();
    TreeNode node;
    if (built.lower) {
      node.axis = static_cast<uint8_t>(built.split.axis);
      node.plane = static_cast<uint16_t>(built.split.plane * grid_.side);
      // Children come after their node, in the order that boxes_file.h reads them in.
      node.lower = flatten(*built.lower, tree);
      node.upper = flatten(*built.upper, tree);
    } else {
      node.box = static_cast<int32_t>(tree.boxes.size());
      tree.boxes.push_back(boxOfBricks(grid_, built.leaf.bricks, parameters_));
      tree.texture_of.push_back(textureOf(built.leaf, tree));
    }
    tree.nodes[static_cast<size_t>(at)] = node;
    return at;
  }

  uint32_t textureOf(const Piece& leaf, BoxTree& tree) {
    // A piece draws from its parent's texture, which is stored once.
    const bool stands_alone =
        leaf.owner == kNone || given_up_[static_cast<size_t>(leaf.owner)] != 0;
    const Box3& bricks =
        stands_alone ? leaf.bricks : owned_[static_cast<size_t>(leaf.owner)].bricks;
    if (!stands_alone) {
      int32_t& texture = texture_of_owner_[static_cast<size_t>(leaf.owner)];
      if (texture != kNone) return static_cast<uint32_t>(texture);
      texture = static_cast<int32_t>(tree.textures.size());
    }
    tree.textures.push_back(boxOfBricks(grid_, bricks, parameters_));
    return static_cast<uint32_t>(tree.textures.size() - 1);
  }

  const BrickGrid& grid_;
  const GrowingParameters& parameters_;
  GrowingParameters wide_;             // the limits of rule 3
  std::vector<Piece> pieces_, owned_;  // the grown boxes; owned_ stays
  std::vector<uint8_t> given_up_;      // by owner: no longer a parent
  std::vector<int32_t> texture_of_owner_;
  std::vector<int64_t> begins_, ends_;  // faces at each plane of a room
};

}  // namespace

BoxTree boxTree(const BrickGrid& grid, std::span<const GrownBox> boxes,
                const GrowingParameters& parameters) {
  SLUICE_CHECK(!boxes.empty());
  const Vec3i size = grid.size;
  SLUICE_CHECK_LE(std::max({size.x, size.y, size.z}), kMostBricks);
  return Converter(grid, boxes, parameters).convert();
}

BoxTree growBoxTree(const BrickGrid& grid, const GrowingParameters& parameters) {
  return boxTree(grid, growBoxes(grid, parameters), parameters);
}

}  // namespace sluice
