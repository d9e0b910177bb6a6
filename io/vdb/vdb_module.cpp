#include "io/vdb/vdb_module.h"

#include <openvdb/io/Compression.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <istream>
#include <limits>
#include <streambuf>
#include <utility>

#include "io/vdb/vdb_library_grids.h"
#include "io/vdb/vdb_tree_walk.h"
#include "src/base/error.h"
#include "src/base/sources/region_check.h"

namespace sluice {
namespace {

constexpr int64_t kCoordLo = std::numeric_limits<int32_t>::min();
constexpr int64_t kCoordEnd = int64_t{std::numeric_limits<int32_t>::max()} + 1;

// The voxel type that is delivered for a grid's value type.
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

// Bytes [begin, end) of a file as a stream, without seeking.
class FileBuffer final : public std::streambuf {
 public:
  FileBuffer(ByteStore& file, uint64_t begin, uint64_t end)
      : file_(file), position_(begin), end_(end) {}

 protected:
  int_type underflow() override {
    const auto bytes = static_cast<size_t>(std::min<uint64_t>(end_ - position_, window_.size()));
    if (bytes == 0) return traits_type::eof();
    const iovec part{window_.data(), bytes};
    file_.read(position_, std::span(&part, 1));
    position_ += bytes;
    setg(window_.data(), window_.data(), window_.data() + bytes);
    return traits_type::to_int_type(window_[0]);
  }

 private:
  ByteStore& file_;
  uint64_t position_;  // offset behind the window
  const uint64_t end_;
  std::vector<char> window_ = std::vector<char>(size_t{64} << 10);
};

// Bytes in memory as a stream.
class MemoryBuffer final : public std::streambuf {
 public:
  void set(std::span<char> bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }
};

// A source for a grid of a known type. The tree keeps only its nodes: a leaf's values are decoded
// from its place in the file whenever they are read. Leaves carry their number in the file's order.
template <class Grid>
class VdbSource final : public VolumeSource {
 public:
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Grid::ValueType;
  using Out = typename Delivered<Value>::Type;
  // Grids of a bit a voxel keep their leaves, which take no more than their masks do.
  static constexpr bool kIsBits = std::is_same_v<Out, uint8_t>;

  explicit VdbSource(const VdbOpening& opening)
      : path_(opening.path),
        file_(opening.file),
        info_(opening.info),
        identity_(opening.identity),
        disk_(opening.tree),
        grid_(Grid::create()) {
    readTree();
    const auto found = grid_->evalActiveVoxelBoundingBox();
    const Box3 active =
        found.empty() ? Box3{} : Box3{vecOf(found.min()), vecOf(found.max()) + Vec3i{1, 1, 1}};
    // A layer of the value around them is shown, too (see vdb_source.h).
    Box3 box{active.lo - Vec3i{1, 1, 1}, active.hi + Vec3i{1, 1, 1}};
    if (opening.box) {
      box = *opening.box;
      // Boxes of a series come from its files' metadata; voxels outside of them would vanish.
      if (!found.empty() && !box.contains(active))
        fail("{}: grid \"{}\" has voxels outside of the box that its file states; write it again",
             path_, info_.name);
    } else if (found.empty()) {
      fail("{}: grid \"{}\" has no active voxels: nothing to show", path_, info_.name);
    }
    lo_ = box.lo;
    layout_.dims = box.size();
    layout_.type = kTypeOf<Out>;
    layout_.name = info_.name + (info_.grid_class == "level set" ? " (level set)" : "");
    layout_.path = path_;
    if (layout_.type == VoxelType::kU8) layout_.stored_range = ValueRange{0, 1};
    layout_.frame = WorldFrame::kYUp;
    layout_.grids = opening.grids;
    layout_.notes = opening.notes;
    placeGrid();
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  std::vector<std::string> files() override { return {path_}; }
  uint64_t storedBytesRead() const override { return file_->storedBytesRead(); }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    checkRegion(layout_, time, box, out);
    std::byte* const voxels = out.data();
    fillRow(voxels, box.count(), grid_->background());
    const Box3 region = translate(box, lo_);
    std::vector<LeafPart> leaves;
    try {
      TreeWalk walk(
          grid_->constTree(), clampToCoords(region),
          [&](const Leaf& leaf, const Box3& part) {
            if constexpr (kIsBits)
              copyBits(leaf, part, region, voxels);
            else
              leaves.push_back({leaf.transientData(), part});
          },
          [&](const Value& value, const Box3& part) {
            forRows(part, region, voxels, [&](std::byte* row, Vec3i /*at*/, int64_t count) {
              fillRow(row, count, value);
            });
          });
      walk.run();
      if constexpr (!kIsBits) readLeaves(leaves, region, voxels);
    } catch (const Error&) {
      throw;
    } catch (const std::exception& e) {  // OpenVDB's own
      fail("{}: grid \"{}\", voxels from ({}, {}, {}): {}", path_, layout_.name, region.lo.x,
           region.lo.y, region.lo.z, e.what());
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
  // A leaf by its number, and the wanted part of it.
  struct LeafPart {
    uint32_t leaf;
    Box3 part;
  };
  // Leaves that lie closer together than a page in the file are read at once, up to this much.
  static constexpr uint64_t kGapBytes = 4096, kRunBytes = uint64_t{256} << 10;

  void prepare(std::istream& stream) const {
    stream.exceptions(std::ios::badbit);  // an Error of the file, on its way through the stream
    openvdb::io::setVersion(stream, {info_.library_major, info_.library_minor}, info_.file_version);
    openvdb::io::setDataCompression(stream, disk_.compression);
  }

  void readTree() {
    FileBuffer transform(*file_, info_.transform_at, info_.end);
    std::istream transform_stream(&transform);
    prepare(transform_stream);
    grid_->readTransform(transform_stream);
    FileBuffer buffer(*file_, disk_.tree_at, disk_.leaves_at.back());
    std::istream stream(&buffer);
    openvdb::io::StreamMetadata::Ptr metadata(new openvdb::io::StreamMetadata);
    openvdb::io::setStreamMetadataPtr(stream, metadata, /*transfer=*/false);
    prepare(stream);
    grid_->tree().readTopology(stream, disk_.saved_as_half);
    if constexpr (kIsBits) {
      FileBuffer values(*file_, disk_.leaves_at.front(), disk_.leaves_at.back());
      std::istream value_stream(&values);
      openvdb::io::setStreamMetadataPtr(value_stream, metadata, /*transfer=*/false);
      prepare(value_stream);
      if (disk_.leaves_at.size() > 1) grid_->tree().readBuffers(value_stream, false);
      if (!value_stream) fail("{}: grid \"{}\" is cut short", path_, info_.name);
    }
    if (!stream) fail("{}: grid \"{}\" is cut short", path_, info_.name);
    uint32_t leaves = 0;
    for (auto leaf = grid_->tree().beginLeaf(); leaf; ++leaf) leaf->setTransientData(leaves++);
    if (leaves + size_t{1} != disk_.leaves_at.size())
      fail("{}: damaged OpenVDB file: grid \"{}\" has {} leaves, its tree {}", path_, info_.name,
           disk_.leaves_at.size() - 1, leaves);
  }

  void readLeaves(std::vector<LeafPart>& leaves, const Box3& region, std::byte* voxels) {
    std::sort(leaves.begin(), leaves.end(),
              [](const LeafPart& a, const LeafPart& b) { return a.leaf < b.leaf; });
    const auto begin = [&](size_t i) { return disk_.leaves_at[leaves[i].leaf]; };
    const auto end = [&](size_t i) { return disk_.leaves_at[leaves[i].leaf + size_t{1}]; };
    MemoryBuffer buffer;
    std::istream stream(&buffer);
    prepare(stream);
    // Inactive values are not stored; OpenVDB takes them from the grid behind the stream.
    openvdb::io::setGridBackgroundValuePtr(stream, &grid_->background());
    std::vector<char> run;
    for (size_t first = 0; first < leaves.size();) {
      size_t last = first;
      while (last + 1 < leaves.size() && begin(last + 1) - end(last) <= kGapBytes &&
             end(last + 1) - begin(first) <= kRunBytes)
        ++last;
      run.resize(end(last) - begin(first));
      const iovec part{run.data(), run.size()};
      file_->read(begin(first), std::span(&part, 1));
      for (size_t i = first; i <= last; ++i) {
        buffer.set(std::span(run).subspan(begin(i) - begin(first), end(i) - begin(i)));
        stream.clear();
        copyLeaf(stream, leaves[i].part, region, voxels);
      }
      first = last + 1;
    }
  }

  void copyLeaf(std::istream& stream, const Box3& part, const Box3& region, std::byte* voxels) {
    constexpr openvdb::Index kStride = Leaf::DIM * Leaf::DIM;  // from one x to the next
    typename Leaf::NodeMaskType active;
    active.load(stream);
    std::array<Value, Leaf::SIZE> values;
    openvdb::io::readCompressedValues(stream, values.data(), Leaf::SIZE, active,
                                      disk_.saved_as_half);
    if (!stream)
      fail("{}: damaged OpenVDB file: grid \"{}\": the values of a leaf are cut short", path_,
           info_.name);
    forRows(part, region, voxels, [&](std::byte* row, Vec3i at, int64_t count) {
      const Value* from = values.data() + Leaf::coordToOffset(coordOf(at));
      for (int64_t i = 0; i < count; ++i) put(row, i, from[i * kStride]);
    });
  }

  // A bit a voxel.
  void copyBits(const Leaf& leaf, const Box3& part, const Box3& region, std::byte* voxels) {
    constexpr openvdb::Index kStride = Leaf::DIM * Leaf::DIM;
    forRows(part, region, voxels, [&](std::byte* row, Vec3i at, int64_t count) {
      const openvdb::Index first = Leaf::coordToOffset(coordOf(at));
      for (int64_t i = 0; i < count; ++i)
        put(row, i, leaf.getValue(first + static_cast<openvdb::Index>(i) * kStride));
    });
  }

  // The caller's bytes may be aligned for no more than bytes.
  static void put(std::byte* row, int64_t i, const Value& value) {
    const Out delivered = static_cast<Out>(value);
    std::memcpy(row + i * static_cast<int64_t>(sizeof(Out)), &delivered, sizeof(Out));
  }
  static void fillRow(std::byte* row, int64_t count, const Value& value) {
    for (int64_t i = 0; i < count; ++i) put(row, i, value);
  }

  // The padding may lie one voxel beyond OpenVDB's coordinates; the background is there.
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

  // OpenVDB multiplies rows from the left, so the rows of its matrix are the axes' steps.
  void placeGrid() {
    const openvdb::math::Transform& transform = grid_->transform();
    if (!transform.isLinear())
      fail("{}: grid \"{}\" has a \"{}\" transform, expected an affine one; resample it first",
           path_, info_.name, std::string(transform.mapType()));
    const auto matrix = transform.baseMap()->getAffineMap()->getMat4();
    for (int a = 0; a < 3; ++a) {
      const Vec3d step{matrix(a, 0), matrix(a, 1), matrix(a, 2)};
      layout_.spacing[a] = length(step);
      if (!(layout_.spacing[a] > 0) || !std::isfinite(layout_.spacing[a]))
        fail("{}: grid \"{}\" has voxels of size {} along axis {}, expected a positive size", path_,
             info_.name, layout_.spacing[a], a);
      layout_.axes[static_cast<size_t>(a)] = normalized(step);
    }
    const auto at = transform.indexToWorld(openvdb::Vec3d(
        static_cast<double>(lo_.x), static_cast<double>(lo_.y), static_cast<double>(lo_.z)));
    layout_.origin = {at.x(), at.y(), at.z()};
    const auto& [x, y, z] = layout_.axes;
    if (!std::isfinite(at.x() + at.y() + at.z()) || !(std::abs(dot(cross(x, y), z)) > 1e-6))
      fail("{}: grid \"{}\" has a transform to no place, or one in which its axes lie in one plane",
           path_, info_.name);
  }

  const std::string path_;
  const std::shared_ptr<ByteStore> file_;
  const VdbGridInfo info_;
  const std::string identity_;
  const VdbTreeOnDisk disk_;
  const typename Grid::Ptr grid_;  // constant after construction, as all that follows
  Vec3i lo_;                       // index of voxel (0, 0, 0)
  VolumeLayout layout_;
};

std::unique_ptr<VolumeSource> sourceOf(const VdbOpening& opening) {
  const std::string& type = opening.info.value_type;
  if (type == "float") return std::make_unique<VdbSource<openvdb::FloatGrid>>(opening);
  if (type == "double") return std::make_unique<VdbSource<openvdb::DoubleGrid>>(opening);
  if (type == "int32") return std::make_unique<VdbSource<openvdb::Int32Grid>>(opening);
  if (type == "int64") return std::make_unique<VdbSource<openvdb::Int64Grid>>(opening);
  if (type == "bool") return std::make_unique<VdbSource<openvdb::BoolGrid>>(opening);
  if (type == "mask") return std::make_unique<VdbSource<openvdb::MaskGrid>>(opening);
  fail("{}: grid \"{}\" holds {}, which is not read", opening.path, opening.info.name, type);
}

}  // namespace
}  // namespace sluice

extern "C" const char* sluiceOpenVdbVersion() {
  return sluice::kOpenVdbModuleVersion;
}

extern "C" void sluiceOpenVdbGrid(const sluice::VdbOpening& opening,
                                  std::unique_ptr<sluice::VolumeSource>& source) {
  using namespace sluice;
  try {
    openvdb::initialize();
    source = sourceOf(opening);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail("{}: grid \"{}\" cannot be read: {}", opening.path, opening.info.name, e.what());
  }
}
