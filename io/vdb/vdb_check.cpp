#include "io/vdb/vdb_check.h"

#include <array>
#include <bit>
#include <span>
#include <string_view>
#include <vector>

#include "io/vdb/vdb_reader.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// OpenVDB's flags of a grid's compression.
constexpr uint32_t kZip = 1, kActiveMask = 2, kBlosc = 4;

// The kind of a node's inactive values, stored in a byte before its values.
enum NodeInactive : uint8_t {
  kBackground = 0,
  kMinusBackground = 1,
  kOneValue = 2,
  kMaskOfSigns = 3,
  kMaskAndOneValue = 4,
  kMaskAndTwoValues = 5,
  kAllStored = 6,
};

constexpr uint64_t kCoordBytes = 12;

using Mask = std::vector<uint64_t>;

class TreeCheck {
 public:
  TreeCheck(File& file, const VdbGridInfo& grid) : grid_(grid), reader_(file) {
    const std::string& type = grid.value_type;
    is_bits_ = type == "bool" || type == "mask";
    is_mask_ = type == "mask";
    value_bytes_ = is_bits_ ? 1 : type == "float" || type == "int32" ? 4 : 8;
    // OpenVDB halves real numbers alone, whatever the flag says of other types.
    stored_bytes_ = grid.saved_as_half && (type == "float" || type == "double") ? 2 : value_bytes_;
    is_half_ = stored_bytes_ != value_bytes_;
  }

  // Returns no leaves for a grid that shares the tree of another one.
  VdbTreeOnDisk run() {
    VdbTreeOnDisk result;
    reader_.seek(grid_.transform_at);
    skipTransform();
    if (!grid_.instance_of.empty()) return result;
    result.tree_at = reader_.position();
    result.compression = grid_.compression;
    result.saved_as_half = grid_.saved_as_half;
    // OpenVDB no longer knows several buffers; it warns and reads on.
    if (reader_.number<uint32_t>() != 1) damaged("a tree with several buffers");
    checkRoot();
    if (reader_.position() > grid_.values_at) damaged("the tree runs into its values");
    reader_.seek(grid_.values_at);
    for (int64_t i = 0; i < leaves_; ++i) {
      result.leaves_at.push_back(reader_.position());
      checkLeafValues();
    }
    result.leaves_at.push_back(reader_.position());
    if (reader_.position() > grid_.end) damaged("the values run past their end");
    return result;
  }

 private:
  [[noreturn]] void damaged(std::string_view what) const {
    fail("{}: damaged OpenVDB file: grid \"{}\", byte {}: {}", reader_.path(), grid_.name,
         reader_.position(), what);
  }

  void skipTransform() {
    const std::string type = reader_.text();
    constexpr uint64_t kVec = 3 * sizeof(double), kMatrix = 16 * sizeof(double);
    if (type == "AffineMap" || type == "UnitaryMap") return reader_.skip(kMatrix);
    if (type == "TranslationMap") return reader_.skip(kVec);
    if (type == "ScaleMap" || type == "UniformScaleMap") return reader_.skip(5 * kVec);
    if (type == "ScaleTranslateMap" || type == "UniformScaleTranslateMap")
      return reader_.skip(6 * kVec);
    if (type == "NonlinearFrustumMap")
      fail(
          "{}: grid \"{}\" has the transform of a frustum, expected an affine one; resample it "
          "first",
          reader_.path(), grid_.name);
    damaged("a transform of an unknown kind");
  }

  void checkRoot() {
    reader_.skip(value_bytes_);  // background
    const auto tiles = reader_.number<uint32_t>();
    const auto children = reader_.number<uint32_t>();
    constexpr uint64_t kActiveByte = 1;
    reader_.skip(tiles * (kCoordBytes + value_bytes_ + kActiveByte));
    for (uint32_t i = 0; i < children; ++i) {
      reader_.skip(kCoordBytes);
      checkNode({5, 4});
    }
  }

  // A node with 2^log2s[0] children a side, and the nodes below it.
  void checkNode(std::span<const int> log2s) {
    if (log2s.empty()) {
      reader_.skip(kLeafMaskBytes);
      ++leaves_;
      return;
    }
    const uint64_t slots = uint64_t{1} << (3 * log2s[0]);
    const Mask children = readMask(slots);
    const Mask active = readMask(slots);
    checkValues(slots, active);
    for (uint64_t i = countOn(children); i > 0; --i) checkNode(log2s.subspan(1));
  }
  void checkNode(std::array<int, 2> log2s) { checkNode(std::span<const int>(log2s)); }

  void checkLeafValues() {
    if (is_bits_) {  // fixed size: the mask of active voxels, the origin, the voxels
      reader_.skip(kLeafMaskBytes + kCoordBytes + (is_mask_ ? 0 : kLeafMaskBytes));
    } else {
      checkValues(kLeafSlots, readMask(kLeafSlots));
    }
  }

  // The values of a node of `slots`, as OpenVDB's readCompressedValues takes them.
  void checkValues(uint64_t slots, const Mask& active) {
    const auto inactive = reader_.number<uint8_t>();
    const bool is_masked = (grid_.compression & kActiveMask) != 0;
    if (inactive > kAllStored || (!is_masked && inactive != kAllStored))
      damaged("a node's values are encoded in an unknown way");
    if (inactive == kOneValue || inactive == kMaskAndOneValue || inactive == kMaskAndTwoValues)
      reader_.skip(value_bytes_);
    if (inactive == kMaskAndTwoValues) reader_.skip(value_bytes_);
    if (inactive == kMaskOfSigns || inactive == kMaskAndOneValue || inactive == kMaskAndTwoValues)
      reader_.skip(slots / 8);
    const uint64_t count = inactive == kAllStored ? slots : countOn(active);
    // OpenVDB writes no length for an empty array of halves, but one of 0 for other types.
    if (is_half_ && count == 0) return;
    const uint64_t bytes = count * stored_bytes_;
    if ((grid_.compression & (kZip | kBlosc)) == 0) return reader_.skip(bytes);
    // The compressed length, or the plain one negative if compression did not pay.
    const auto length = reader_.number<int64_t>();
    // Unsigned, as the negation of the smallest length would overflow.
    if (length <= 0 && uint64_t{0} - static_cast<uint64_t>(length) != bytes)
      damaged("a node's values are of another length than the node");
    reader_.skip(length > 0 ? static_cast<uint64_t>(length) : bytes);
  }

  Mask readMask(uint64_t bits) {
    Mask mask(bits / 64);
    reader_.read(mask.data(), bits / 8);
    return mask;
  }
  static uint64_t countOn(const Mask& mask) {
    uint64_t count = 0;
    for (const uint64_t word : mask) count += static_cast<uint64_t>(std::popcount(word));
    return count;
  }

  static constexpr uint64_t kLeafSlots = 512;
  static constexpr uint64_t kLeafMaskBytes = kLeafSlots / 8;

  const VdbGridInfo& grid_;
  VdbReader reader_;
  bool is_bits_ = false, is_mask_ = false, is_half_ = false;
  uint64_t value_bytes_ = 0;   // in memory
  uint64_t stored_bytes_ = 0;  // in arrays on disk
  int64_t leaves_ = 0;
};

}  // namespace

VdbTreeOnDisk checkVdbGrid(File& file, const std::vector<VdbGridInfo>& grids,
                           const VdbGridInfo& grid) {
  if (grid.tree_shape != "5_4_3")
    fail(
        "{}: grid \"{}\" is a tree of the shape {}, expected 5_4_3; write it again as a standard "
        "grid",
        file.path(), grid.name, grid.tree_shape);
  VdbTreeOnDisk tree = TreeCheck(file, grid).run();
  if (grid.instance_of.empty()) return tree;
  for (const VdbGridInfo& other : grids) {
    // One that is shared itself is not followed: two such grids could name each other for ever.
    if (other.name == grid.instance_of && other.instance_of.empty() &&
        other.value_type == grid.value_type)
      return checkVdbGrid(file, grids, other);
  }
  fail("{}: damaged OpenVDB file: grid \"{}\" shares the tree of \"{}\", which is not among {}",
       file.path(), grid.name, grid.instance_of, describe(grids));
}

}  // namespace sluice
