// A walk over the part of an OpenVDB tree that lies in a box.
//
// Known to the module alone (see vdb_module.h). A walk reads the tree's nodes and none of the
// leaves' values; any number may be under way at once.
#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <utility>

#include "src/base/values/vec.h"

namespace sluice {

// Requires: the numbers fit 32 bits, as OpenVDB's coordinates do.
inline openvdb::Coord coordOf(Vec3i p) {
  return {static_cast<int32_t>(p.x), static_cast<int32_t>(p.y), static_cast<int32_t>(p.z)};
}
inline Vec3i vecOf(const openvdb::Coord& c) {
  return {c.x(), c.y(), c.z()};
}

// The part of a node's box of size `size` voxels at `at` that lies in `region`.
inline Box3 partOf(const openvdb::Coord& at, int64_t size, const Box3& region) {
  const Vec3i lo = vecOf(at);
  return intersect({lo, lo + Vec3i{size, size, size}}, region);
}

// Walks the tree inside `region` (index space, within the coordinates' range) and calls
// on_leaf(leaf, part) and on_tile(value, part) for everything that differs from the background as a
// whole.
template <class Tree, class OnLeaf, class OnTile>
class TreeWalk {
 public:
  TreeWalk(const Tree& tree, const Box3& region, OnLeaf on_leaf, OnTile on_tile)
      : tree_(tree),
        region_(region),
        background_(tree.background()),
        on_leaf_(std::move(on_leaf)),
        on_tile_(std::move(on_tile)) {}

  void run() {
    using Child = typename Tree::RootNodeType::ChildNodeType;
    const auto& root = tree_.root();
    // A read of a block asks the root's table for the few places it covers; a walk over more places
    // than the table has entries goes through the table.
    const int64_t size = Child::DIM;
    Vec3i first, count;
    double places = 1;
    for (int a = 0; a < 3; ++a) {
      first[a] = region_.lo[a] & ~(size - 1);
      count[a] = ceilDiv(region_.hi[a] - first[a], size);
      places *= static_cast<double>(count[a]);
    }
    if (places <= root.getTableSize()) {
      for (int64_t z = 0; z < count.z; ++z)
        for (int64_t y = 0; y < count.y; ++y)
          for (int64_t x = 0; x < count.x; ++x) {
            const openvdb::Coord at = coordOf(first + Vec3i{x, y, z} * size);
            if (const auto* child = root.template probeConstNode<Child>(at)) {
              visit(*child);
            } else {
              visitTile(root.getValue(at), partOf(at, size, region_));
            }
          }
      return;
    }
    for (auto child = root.cbeginChildOn(); child; ++child) visit(*child);
    for (auto tile = root.cbeginValueAll(); tile; ++tile)
      visitTile(*tile, partOf(tile.getCoord(), size, region_));
  }

 private:
  template <class Node>
  void visit(const Node& node) {
    const Box3 part = partOf(node.origin(), Node::DIM, region_);
    if (part.empty()) return;
    if constexpr (Node::LEVEL == 0) {
      on_leaf_(node, part);
    } else {
      constexpr int64_t kSize = Node::ChildNodeType::DIM;
      const Vec3i origin = vecOf(node.origin());
      const Vec3i first = (part.lo - origin) / Vec3i{kSize, kSize, kSize};
      const Vec3i last = (part.hi - origin - Vec3i{1, 1, 1}) / Vec3i{kSize, kSize, kSize};
      for (int64_t x = first.x; x <= last.x; ++x)
        for (int64_t y = first.y; y <= last.y; ++y)
          for (int64_t z = first.z; z <= last.z; ++z) {
            const openvdb::Coord at = coordOf(origin + Vec3i{x, y, z} * kSize);
            const openvdb::Index n = Node::coordToOffset(at);
            if (node.getChildMask().isOn(n)) {
              visit(*node.getTable()[n].getChild());
            } else {
              visitTile(node.getTable()[n].getValue(), partOf(at, kSize, region_));
            }
          }
    }
  }

  template <class Value>
  void visitTile(const Value& value, const Box3& part) {
    if (!part.empty() && !(value == background_)) on_tile_(value, part);
  }

  const Tree& tree_;
  const Box3 region_;
  const typename Tree::ValueType background_;
  OnLeaf on_leaf_;
  OnTile on_tile_;
};

}  // namespace sluice
