#include "io/vdb/vdb_header.h"

#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "io/vdb/vdb_reader.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMagic = 0x56444220;
constexpr uint32_t kOldestVersion = 222;  // oldest encoding of nodes that vdb_check.cpp knows
constexpr uint32_t kMaxGrids = 1 << 20;

struct Metadata {
  std::string grid_class;
  bool is_half = false;
  std::optional<Vec3i> active_min, active_max;
};

// A vec3i's bytes. Requires: well sized.
Vec3i vectorOf(const std::string& bytes) {
  std::array<int32_t, 3> v{};
  std::memcpy(v.data(), bytes.data(), sizeof v);
  return {v[0], v[1], v[2]};
}

// OpenVDB reads as many bytes of a metadatum as its type has, whatever length stands before it.
bool isWellSized(const std::string& type, size_t bytes) {
  static constexpr std::array<std::pair<std::string_view, size_t>, 16> kSizes{{{"bool", 1},
                                                                               {"int32", 4},
                                                                               {"int64", 8},
                                                                               {"float", 4},
                                                                               {"double", 8},
                                                                               {"vec2i", 8},
                                                                               {"vec2s", 8},
                                                                               {"vec2d", 16},
                                                                               {"vec3i", 12},
                                                                               {"vec3s", 12},
                                                                               {"vec3d", 24},
                                                                               {"vec4i", 16},
                                                                               {"vec4s", 16},
                                                                               {"vec4d", 32},
                                                                               {"mat4s", 64},
                                                                               {"mat4d", 128}}};
  for (const auto& [name, size] : kSizes) {
    if (type == name) return bytes == size;
  }
  return true;
}

// A name or a type, which messages print.
std::string nameFrom(VdbReader& reader) {
  constexpr size_t kMostBytes = 256;
  std::string name = reader.text();
  if (name.size() > kMostBytes)
    fail("{}: damaged OpenVDB file: a name of {} bytes, expected at most {}", reader.path(),
         name.size(), kMostBytes);
  return name;
}

// The type that a metadatum which is looked at must have; empty: any.
std::string_view typeOf(std::string_view key) {
  if (key == "class") return "string";
  if (key == "is_saved_as_half_float") return "bool";
  if (key == "file_bbox_min" || key == "file_bbox_max") return "vec3i";
  return "";
}

// Walks a block of named metadata.
Metadata readMetadata(VdbReader& reader) {
  Metadata result;
  const auto count = reader.number<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    const std::string key = nameFrom(reader);
    const std::string type = nameFrom(reader);
    const std::string value = reader.text();
    if (!isWellSized(type, value.size()))
      fail("{}: damaged OpenVDB file: metadatum \"{}\" of type {} has {} bytes", reader.path(), key,
           type, value.size());
    const std::string_view expected = typeOf(key);
    if (!expected.empty() && type != expected)
      fail("{}: damaged OpenVDB file: metadatum \"{}\" has the type \"{}\", expected {}",
           reader.path(), key, type, expected);
    if (key == "class") result.grid_class = value;
    // isWellSized() has seen to the byte.
    if (key == "is_saved_as_half_float") result.is_half = value[0] != 0;
    if (key == "file_bbox_min") result.active_min = vectorOf(value);
    if (key == "file_bbox_max") result.active_max = vectorOf(value);
  }
  return result;
}

// OpenVDB tells grids of one name apart by a number after an ASCII record separator.
std::string readableName(const std::string& unique) {
  const size_t separator = unique.find('\x1e');
  if (separator == std::string::npos) return unique;
  return unique.substr(0, separator) + "[" + unique.substr(separator + 1) + "]";
}

// "Tree_float_5_4_3" or "Tree_float_5_4_3_HalfFloat"; other names are kept as the value type.
void splitTreeType(std::string tree_type, VdbGridInfo& grid) {
  const std::string prefix = "Tree_", half_suffix = "_HalfFloat";
  if (tree_type.ends_with(half_suffix)) {
    grid.saved_as_half = true;
    tree_type.resize(tree_type.size() - half_suffix.size());
  }
  grid.value_type = tree_type;
  if (!tree_type.starts_with(prefix)) return;
  const size_t value_end = tree_type.find('_', prefix.size());
  grid.value_type = tree_type.substr(prefix.size(), value_end - prefix.size());
  if (value_end != std::string::npos) grid.tree_shape = tree_type.substr(value_end + 1);
}

VdbGridInfo readGrid(VdbReader& reader) {
  VdbGridInfo grid;
  grid.name = readableName(nameFrom(reader));
  splitTreeType(nameFrom(reader), grid);
  grid.instance_of = readableName(nameFrom(reader));
  const auto grid_at = reader.number<uint64_t>();
  grid.values_at = reader.number<uint64_t>();
  grid.end = reader.number<uint64_t>();
  // All lies behind what tells of it: a damaged offset shows here, not as other bytes.
  if (grid_at < reader.position() || grid.values_at < grid_at || grid.end < grid.values_at)
    fail("{}: damaged OpenVDB file: grid \"{}\" lies at {} to {} with its values at {}",
         reader.path(), grid.name, grid_at, grid.end, grid.values_at);
  reader.seek(grid_at);
  grid.compression = reader.number<uint32_t>();
  const Metadata metadata = readMetadata(reader);
  // The stored length of a number follows from either of them.
  if (metadata.is_half != grid.saved_as_half)
    fail(
        "{}: damaged OpenVDB file: the type and the metadata of grid \"{}\" disagree on half "
        "precision",
        reader.path(), grid.name);
  grid.grid_class = metadata.grid_class.substr(0, 64);  // messages print it
  if (metadata.active_min && metadata.active_max)
    grid.active = Box3{*metadata.active_min, *metadata.active_max + Vec3i{1, 1, 1}};
  grid.transform_at = reader.position();
  reader.seek(grid.end);
  return grid;
}

bool isReal(const VdbGridInfo& grid) {
  return grid.value_type == "float" || grid.value_type == "double";
}
}  // namespace

bool isScalar(const VdbGridInfo& grid) {
  return isReal(grid) || grid.value_type == "int32" || grid.value_type == "int64" ||
         grid.value_type == "bool" || grid.value_type == "mask";
}

std::vector<VdbGridInfo> readVdbGrids(File& file) {
  VdbReader reader(file);
  if (reader.size() < sizeof kMagic || reader.number<uint64_t>() != kMagic)
    fail("{}: not an OpenVDB file (its first bytes are not OpenVDB's)", reader.path());
  const auto version = reader.number<uint32_t>();
  if (version < kOldestVersion)
    fail("{}: OpenVDB file format {}, expected {} or later; write it again with a newer OpenVDB",
         reader.path(), version, kOldestVersion);
  const auto library_major = reader.number<uint32_t>();
  const auto library_minor = reader.number<uint32_t>();
  const bool has_table = reader.number<uint8_t>() != 0;
  constexpr uint64_t kUuidBytes = 36;
  reader.skip(kUuidBytes);
  readMetadata(reader);
  // Streams have no offsets of leaves, without which values cannot be read one by one.
  if (!has_table)
    fail(
        "{}: OpenVDB file without a table of its grids (written through a pipe); "
        "write it again with vdb_tool -read IN.vdb -write OUT.vdb",
        reader.path());

  const auto count = reader.number<uint32_t>();
  if (count > kMaxGrids) fail("{}: damaged OpenVDB file: it states {} grids", reader.path(), count);
  std::vector<VdbGridInfo> grids;
  for (uint32_t i = 0; i < count; ++i) {
    grids.push_back(readGrid(reader));
    grids.back().file_version = version;
    grids.back().library_major = library_major;
    grids.back().library_minor = library_minor;
  }
  return grids;
}

VdbGridInfo chooseVdbGrid(const std::string& path, const std::vector<VdbGridInfo>& grids,
                          const std::string& wanted) {
  if (!wanted.empty()) {
    for (const VdbGridInfo& grid : grids) {
      if (grid.name != wanted) continue;
      if (isScalar(grid)) return grid;
      fail(
          "{}: grid \"{}\" holds {}, expected float, double, int32, int64, bool or mask; it has {}",
          path, wanted, grid.value_type, describe(grids));
    }
    fail("{}: no grid \"{}\"; it has {}", path, wanted, describe(grids));
  }
  // Real numbers come first: a mask or an index beside them is rarely what is meant.
  for (const auto accepts : {isReal, isScalar}) {
    for (const VdbGridInfo& grid : grids) {
      if (accepts(grid)) return grid;
    }
  }
  fail("{}: no grid of a scalar type; it has {}", path, describe(grids));
}

std::string describe(const std::vector<VdbGridInfo>& grids) {
  std::string text;
  for (const VdbGridInfo& grid : grids) {
    text += fmt::format("{}{} ({}{}{})", text.empty() ? "" : ", ", grid.name, grid.value_type,
                        grid.grid_class.empty() ? "" : ", ", grid.grid_class);
  }
  return text.empty() ? "none" : text;
}

}  // namespace sluice
