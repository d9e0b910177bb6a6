#include "src/index/boxes_file.h"

#include "src/base/error.h"
#include "src/base/files/byte_stream.h"

namespace sluice {
namespace {

// Replaces the axis for a node without a plane.
constexpr uint8_t kLeaf = 3;

void write(ByteWriter& out, const GrownBox& box) {
  out.value(box.range.lo);
  out.value(box.range.hi);
  out.value(box.range.gradient_lo);
  out.value(box.range.gradient_hi);
  out.value(static_cast<uint8_t>(box.type));
}

// All but the cells. False also for intervals that are none.
bool read(ByteReader& in, GrownBox& box) {
  CellRange& range = box.range;
  uint8_t type = 0;
  if (!in.value(range.lo) || !in.value(range.hi) || !in.value(range.gradient_lo) ||
      !in.value(range.gradient_hi) || !in.value(type))
    return false;
  box.type = static_cast<BoxType>(type);
  return type <= static_cast<uint8_t>(BoxType::kOther) && range.lo <= range.hi &&
         0 <= range.gradient_lo && range.gradient_lo <= range.gradient_hi;
}

void setCells(GrownBox& box, const Box3& cells) {
  for (int a = 0; a < 3; ++a) {
    box.lo[static_cast<size_t>(a)] = static_cast<uint16_t>(cells.lo[a]);
    box.hi[static_cast<size_t>(a)] = static_cast<uint16_t>(cells.hi[a]);
  }
}

struct Room {
  Box3 cells;
  int32_t parent = -1;
  bool upper = false;
  size_t depth = 0;
};

// Reads nodes in their order, each followed by its lower subtree and then its upper one.
class TreeReader {
 public:
  TreeReader(std::span<const std::byte> bytes, Vec3i cells) : in_(bytes), cells_(cells) {}

  std::optional<BoxTree> read() {
    uint32_t textures = 0;
    if (!in_.value(tree_.grown) || !in_.value(textures)) return std::nullopt;
    // Each takes bytes, so that no count leads to more memory than there are.
    for (uint32_t i = 0; i < textures; ++i)
      if (!readTexture()) return std::nullopt;
    // Rooms wait on a stack, because a damaged file might be nested deeper than calls can be.
    std::vector<Room> waiting{{boxOf(cells_), -1, false, 0}};
    while (!waiting.empty()) {
      const Room room = waiting.back();
      waiting.pop_back();
      if (!readNode(room, waiting)) return std::nullopt;
    }
    if (!in_.left().empty() || !texturesAreUsed()) return std::nullopt;
    return std::move(tree_);
  }

 private:
  bool readTexture() {
    GrownBox box;
    if (!in_.value(box.lo) || !in_.value(box.hi) || !sluice::read(in_, box)) return false;
    tree_.textures.push_back(box);
    // A texture must have cells, all of them in the block.
    return !box.local().empty() && boxOf(cells_).contains(box.local());
  }

  bool readNode(const Room& room, std::vector<Room>& waiting) {
    const auto at = static_cast<int32_t>(tree_.nodes.size());
    TreeNode node;
    // The kind of a node is its axis: kLeaf is the one behind z.
    if (!in_.value(node.axis) || node.axis > kLeaf) return false;
    if (room.parent >= 0) {
      TreeNode& parent = tree_.nodes[static_cast<size_t>(room.parent)];
      (room.upper ? parent.upper : parent.lower) = at;
    }
    if (node.axis == kLeaf) {
      node.axis = 0;
      node.box = static_cast<int32_t>(tree_.boxes.size());
      tree_.nodes.push_back(node);
      return readLeaf(room.cells);
    }
    // Walks through a tree rely on this limit.
    if (!in_.value(node.plane) || room.depth >= kMostTreeDepth) return false;
    // The plane must part the room, otherwise a subtree would have no cells.
    if (node.plane <= room.cells.lo[node.axis] || node.plane >= room.cells.hi[node.axis])
      return false;
    tree_.nodes.push_back(node);
    Room low{room.cells, at, false, room.depth + 1}, high{room.cells, at, true, room.depth + 1};
    low.cells.hi[node.axis] = high.cells.lo[node.axis] = node.plane;
    // The lower room is on top, as its nodes come first in the file.
    waiting.push_back(high);
    waiting.push_back(low);
    return true;
  }

  bool readLeaf(const Box3& cells) {
    GrownBox box;
    uint32_t texture = 0;
    if (!in_.value(texture) || !sluice::read(in_, box) || texture >= tree_.textures.size())
      return false;
    // Cells are not stored: they follow from the planes.
    setCells(box, cells);
    tree_.boxes.push_back(box);
    tree_.texture_of.push_back(texture);
    // A box outside its texture would sample voxels that are not its own.
    return tree_.textures[texture].local().contains(cells);
  }

  // They share the block as the leaves do: no voxel is stored for two of them.
  bool texturesAreUsed() const {
    std::vector<int64_t> held(tree_.textures.size(), 0);
    for (size_t i = 0; i < tree_.boxes.size(); ++i)
      held[tree_.texture_of[i]] += tree_.boxes[i].local().count();
    for (size_t i = 0; i < held.size(); ++i)
      if (held[i] != tree_.textures[i].local().count()) return false;
    return true;
  }

  ByteReader in_;
  const Vec3i cells_;
  BoxTree tree_;
};

struct PieceHeader {
  int64_t dims[3];
  int64_t size, ghost, type, brick_side, least_uniform_cells, first, count;
  double scale, offset;
  float parameters[6];
  friend bool operator==(const PieceHeader&, const PieceHeader&) = default;
};

PieceHeader headerOf(const BoxesOrigin& origin, int64_t first, int64_t count) {
  const BlockLayout& layout = origin.layout;
  const GrowingParameters& p = origin.parameters;
  return {{layout.dims.x, layout.dims.y, layout.dims.z},
          layout.size,
          layout.ghost,
          static_cast<int64_t>(origin.map.type),
          origin.brick_side,
          p.least_uniform_cells,
          first,
          count,
          origin.map.scale,
          origin.map.offset,
          {p.uniform_range, p.cost_range, p.gradient_floor, p.flat_cost, p.cost_limit_cells,
           p.mean_cost_limit}};
}

}  // namespace

std::vector<std::byte> serialize(const BoxTree& tree) {
  ByteWriter out;
  out.value(tree.grown);
  out.value(static_cast<uint32_t>(tree.textures.size()));
  for (const GrownBox& texture : tree.textures) {
    out.value(texture.lo);
    out.value(texture.hi);
    write(out, texture);
  }
  // boxTree() leaves the nodes in the order that they are read in.
  for (const TreeNode& node : tree.nodes) {
    if (!node.isLeaf()) {
      out.value(node.axis);
      out.value(node.plane);
      continue;
    }
    out.value(kLeaf);
    out.value(tree.texture_of[static_cast<size_t>(node.box)]);
    write(out, tree.boxes[static_cast<size_t>(node.box)]);
  }
  return std::move(out.bytes);
}

std::optional<BoxTree> deserializeBoxTree(std::span<const std::byte> bytes, Vec3i cells) {
  return TreeReader(bytes, cells).read();
}

std::span<const std::byte> BoxesPiece::treeBytes(int64_t block) const {
  const auto at = static_cast<size_t>(block - first);
  SLUICE_CHECK_LT(at, ends.size());
  const uint64_t from = at == 0 ? 0 : ends[at - 1];
  return std::span(bytes).subspan(from, ends[at] - from);
}

std::vector<std::byte> serialize(const BoxesPiece& piece, const BoxesOrigin& origin) {
  ByteWriter out;
  out.value(headerOf(origin, piece.first, static_cast<int64_t>(piece.ends.size())));
  for (const uint64_t end : piece.ends) out.value(end);
  out.bytes.insert(out.bytes.end(), piece.bytes.begin(), piece.bytes.end());
  return std::move(out.bytes);
}

std::optional<BoxesPiece> deserializeBoxesPiece(std::span<const std::byte> bytes,
                                                const BoxesOrigin& origin, int64_t first,
                                                int64_t count) {
  ByteReader in(bytes);
  PieceHeader header{};
  // A piece made from other voxels, blocks or parameters does not count, see BoxesOrigin.
  if (!in.value(header) || header != headerOf(origin, first, count)) return std::nullopt;
  BoxesPiece piece;
  piece.first = first;
  // The count is the piece's own, and the bytes may be fewer.
  if (in.left().size() / sizeof(uint64_t) < static_cast<uint64_t>(count)) return std::nullopt;
  for (int64_t i = 0; i < count; ++i) {
    uint64_t end = 0;
    const uint64_t least = piece.ends.empty() ? 0 : piece.ends.back();
    // Ends ascend, so that treeBytes() never reaches beyond the bytes.
    if (!in.value(end) || end < least) return std::nullopt;
    piece.ends.push_back(end);
  }
  if (in.left().size() != (piece.ends.empty() ? 0 : piece.ends.back())) return std::nullopt;
  piece.bytes.assign(in.left().begin(), in.left().end());
  return piece;
}

}  // namespace sluice
