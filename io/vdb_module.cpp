#include "io/vdb_module.h"

#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <utility>

#include "src/base/error.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace sluice {
namespace {

constexpr int64_t kCoordLo = std::numeric_limits<int32_t>::min();
constexpr int64_t kCoordEnd = int64_t{std::numeric_limits<int32_t>::max()} + 1;

openvdb::Coord coordOf(Vec3i p) {
  return {static_cast<int32_t>(p.x), static_cast<int32_t>(p.y), static_cast<int32_t>(p.z)};
}
Vec3i vecOf(const openvdb::Coord& c) {
  return {c.x(), c.y(), c.z()};
}

// What a VoxelType delivers for a grid's value type.
template <class Value>
struct Delivered {
  using Type = Value;
};
template <>
struct Delivered<int64_t> {
  using Type = double;
};
template <>
struct Delivered<bool> {
  using Type = uint8_t;
};
template <class T>
constexpr VoxelType kTypeOf = VoxelType::kU8;
template <>
constexpr VoxelType kTypeOf<float> = VoxelType::kF32;
template <>
constexpr VoxelType kTypeOf<double> = VoxelType::kF64;
template <>
constexpr VoxelType kTypeOf<int32_t> = VoxelType::kI32;

// The part of a node's box of size `size` voxels at `at` that lies in `region`.
Box3 partOf(const openvdb::Coord& at, int64_t size, const Box3& region) {
  const Vec3i lo = vecOf(at);
  return intersect({lo, lo + Vec3i{size, size, size}}, region);
}

// Walks the tree inside `region` (index space, within the coordinates' range) and calls
// on_leaf(leaf, part) and on_tile(value, part) for what differs from the background as a whole.
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

// Calls use(values) with the 512 values of a leaf of numbers. A leaf not yet read is decoded into a
// copy of its buffer, which goes with the call, so that reading does not fill memory with the tree.
template <class Leaf, class Use>
void withValues(const Leaf& leaf, Use use) {
  using Buffer = typename Leaf::Buffer;
  if (!leaf.buffer().isOutOfCore()) {
    use(leaf.buffer().data());
    return;
  }
  auto copy = std::make_unique<Buffer>(leaf.buffer());
  const typename Leaf::ValueType* values = nullptr;
  try {
    values = std::as_const(*copy).data();
  } catch (...) {
    // OpenVDB 10 leaves a buffer whose decoding failed in a state that its destructor would free
    // twice. A few kilobytes lost on a damaged file are the lesser harm.
    Buffer* broken = copy.release();
#if defined(__SANITIZE_ADDRESS__)
    __lsan_ignore_object(broken);
#else
    static_cast<void>(broken);
#endif
    throw;
  }
  use(values);
}

// One grid of a known type.
template <class Grid>
class VdbSource final : public VolumeSource {
 public:
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Grid::ValueType;
  using Out = typename Delivered<Value>::Type;

  VdbSource(const VdbOpening& opening, typename Grid::ConstPtr grid)
      : path_(opening.path),
        grid_(std::move(grid)),
        identity_(opening.identity),
        tree_(opening.tree) {
    const VdbGridInfo& info = opening.info;
    const auto box = grid_->evalActiveVoxelBoundingBox();
    if (box.empty())
      fail("{}: grid \"{}\" has no active voxels: nothing to show", path_.string(), info.name);
    lo_ = vecOf(box.min()) - Vec3i{1, 1, 1};
    layout_.dims = vecOf(box.max()) + Vec3i{2, 2, 2} - lo_;
    layout_.type = kTypeOf<Out>;
    const bool is_level_set = grid_->getGridClass() == openvdb::GRID_LEVEL_SET;
    layout_.name = info.name + (is_level_set ? " (level set)" : "");
    if (layout_.type == VoxelType::kU8) layout_.stored_range = ValueRange{0, 1};
    placeGrid(info);
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  uint64_t storedBytesRead() const override {
    return tree_.node_bytes + static_cast<uint64_t>(tree_.bytes_per_leaf *
                                                    static_cast<double>(leaves_decoded_.load()));
  }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    SLUICE_CHECK_EQ(time, 0);
    SLUICE_CHECK(!box.empty() && boxOf(layout_.dims).contains(box));
    SLUICE_CHECK_EQ(out.size(), static_cast<size_t>(box.count()) * sizeof(Out));
    std::byte* const voxels = out.data();
    fillRow(voxels, box.count(), grid_->background());
    const Box3 region = translate(box, lo_);
    try {
      TreeWalk walk(
          grid_->constTree(), clampToCoords(region),
          [&](const Leaf& leaf, const Box3& part) { copyLeaf(leaf, part, region, voxels); },
          [&](const Value& value, const Box3& part) {
            forRows(part, region, voxels, [&](std::byte* row, Vec3i /*at*/, int64_t count) {
              fillRow(row, count, value);
            });
          });
      walk.run();
    } catch (const std::exception& e) {  // OpenVDB's own, and those of the mapped file under it
      fail("{}: grid \"{}\", voxels from ({}, {}, {}): {}", path_.string(), layout_.name,
           region.lo.x, region.lo.y, region.lo.z, e.what());
    }
  }

  std::optional<Occupancy> occupancy(int64_t /*time*/) override {
    Occupancy result;
    result.background = static_cast<double>(grid_->background());
    const auto add = [&](const auto& /*what*/, const Box3& part) {
      result.boxes.push_back(translate(part, -lo_));
    };
    TreeWalk walk(grid_->constTree(), clampToCoords(translate(boxOf(layout_.dims), lo_)), add, add);
    walk.run();
    return result;
  }

 private:
  // The caller's bytes may be aligned for no more than bytes.
  static void put(std::byte* row, int64_t i, const Value& value) {
    const Out delivered = static_cast<Out>(value);
    std::memcpy(row + i * static_cast<int64_t>(sizeof(Out)), &delivered, sizeof(Out));
  }
  static void fillRow(std::byte* row, int64_t count, const Value& value) {
    for (int64_t i = 0; i < count; ++i) put(row, i, value);
  }

  // The padding may lie one voxel beyond what OpenVDB can address; there is the background.
  static Box3 clampToCoords(const Box3& box) {
    return intersect(box, {{kCoordLo, kCoordLo, kCoordLo}, {kCoordEnd, kCoordEnd, kCoordEnd}});
  }

  // Calls f(first voxel in `voxels`, its index, count) for each row of `part`.
  template <class F>
  static void forRows(const Box3& part, const Box3& region, std::byte* voxels, F f) {
    const Vec3i size = region.size();
    for (int64_t z = part.lo.z; z < part.hi.z; ++z)
      for (int64_t y = part.lo.y; y < part.hi.y; ++y) {
        const Vec3i at = Vec3i{part.lo.x, y, z} - region.lo;
        constexpr auto kBytes = static_cast<int64_t>(sizeof(Out));
        f(voxels + ((at.z * size.y + at.y) * size.x + at.x) * kBytes, Vec3i{part.lo.x, y, z},
          part.hi.x - part.lo.x);
      }
  }

  void copyLeaf(const Leaf& leaf, const Box3& part, const Box3& region, std::byte* voxels) {
    constexpr openvdb::Index kStride = Leaf::DIM * Leaf::DIM;  // from one x to the next
    if constexpr (!std::is_same_v<Value, bool>) {
      if (leaf.buffer().isOutOfCore()) ++leaves_decoded_;
      withValues(leaf, [&](const Value* values) {
        forRows(part, region, voxels, [&](std::byte* row, Vec3i at, int64_t count) {
          const Value* from = values + Leaf::coordToOffset(coordOf(at));
          for (int64_t i = 0; i < count; ++i) put(row, i, from[i * kStride]);
        });
      });
    } else {  // a bit a voxel
      forRows(part, region, voxels, [&](std::byte* row, Vec3i at, int64_t count) {
        const openvdb::Index first = Leaf::coordToOffset(coordOf(at));
        for (int64_t i = 0; i < count; ++i)
          put(row, i, leaf.getValue(first + static_cast<openvdb::Index>(i) * kStride));
      });
    }
  }

  // OpenVDB multiplies rows from the left, so the rows of its matrix are the axes' steps.
  void placeGrid(const VdbGridInfo& info) {
    const openvdb::math::Transform& transform = grid_->transform();
    if (!transform.isLinear())
      fail("{}: grid \"{}\" has a \"{}\" transform, expected an affine one; resample it first",
           path_.string(), info.name, std::string(transform.mapType()));
    const auto matrix = transform.baseMap()->getAffineMap()->getMat4();
    for (int a = 0; a < 3; ++a) {
      const Vec3d step{matrix(a, 0), matrix(a, 1), matrix(a, 2)};
      layout_.spacing[a] = length(step);
      if (!(layout_.spacing[a] > 0) || !std::isfinite(layout_.spacing[a]))
        fail("{}: grid \"{}\" has voxels of size {} along axis {}, expected a positive size",
             path_.string(), info.name, layout_.spacing[a], a);
      layout_.axes[static_cast<size_t>(a)] = normalized(step);
    }
    const auto at = transform.indexToWorld(openvdb::Vec3d(
        static_cast<double>(lo_.x), static_cast<double>(lo_.y), static_cast<double>(lo_.z)));
    layout_.origin = {at.x(), at.y(), at.z()};
  }

  const std::filesystem::path path_;
  const typename Grid::ConstPtr grid_;
  Vec3i lo_;  // index of voxel (0, 0, 0)
  VolumeLayout layout_;
  const std::string identity_;
  const VdbTreeOnDisk tree_;
  std::atomic<uint64_t> leaves_decoded_{0};
};

template <class Grid>
std::unique_ptr<VolumeSource> sourceOf(const VdbOpening& opening,
                                       const openvdb::GridBase::Ptr& grid) {
  if (!grid->isType<Grid>()) return nullptr;
  return std::make_unique<VdbSource<Grid>>(opening, openvdb::gridPtrCast<Grid>(grid));
}

}  // namespace
}  // namespace sluice

extern "C" void sluiceOpenVdbGrid(const sluice::VdbOpening& opening,
                                  std::unique_ptr<sluice::VolumeSource>& source) {
  using namespace sluice;
  openvdb::GridBase::Ptr loaded;
  try {
    openvdb::initialize();
    // A table of the leaves' sizes, for a faster opening, which OpenVDB believes whatever it says;
    // unknown to it, it goes by what the leaves say, and that was checked.
    openvdb::io::DelayedLoadMetadata::unregisterType();
    openvdb::io::File file(opening.path.string());
    file.setCopyMaxBytes(0);  // map the file itself; by default small ones are copied to /tmp
    file.open(/*delayLoad=*/true);
    loaded = file.readGrid(opening.info.name);
  } catch (const std::exception& e) {
    fail("{}: grid \"{}\" cannot be read: {}", opening.path.string(), opening.info.name, e.what());
  }
  source = sourceOf<openvdb::FloatGrid>(opening, loaded);
  if (!source) source = sourceOf<openvdb::DoubleGrid>(opening, loaded);
  if (!source) source = sourceOf<openvdb::Int32Grid>(opening, loaded);
  if (!source) source = sourceOf<openvdb::Int64Grid>(opening, loaded);
  if (!source) source = sourceOf<openvdb::BoolGrid>(opening, loaded);
  if (!source) source = sourceOf<openvdb::MaskGrid>(opening, loaded);
  if (!source)
    fail("{}: grid \"{}\" is a tree of an unusual shape ({}); write it again as a standard grid",
         opening.path.string(), opening.info.name, loaded->type());
}
