#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "io/headers/header_fields.h"
#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_array_fields.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Codecs, data types and grids are a name, or an object of a name and a configuration.
std::string nameOf(const JsonField& extension) {
  return extension.isText() ? extension.text() : extension.require("name").text();
}

std::optional<JsonField> settingOf(const JsonField& extension, const char* key) {
  if (extension.isText()) return std::nullopt;
  const auto configuration = extension.find("configuration");
  return configuration ? configuration->find(key) : std::nullopt;
}

JsonField requireSetting(const JsonField& extension, const char* key) {
  return extension.require("configuration").require(key);
}

void setDataType(const JsonField& field, ZarrArray& array) {
  constexpr std::pair<const char*, VoxelType> kTypes[] = {
      {"bool", VoxelType::kU8},    {"uint8", VoxelType::kU8},    {"int8", VoxelType::kI8},
      {"uint16", VoxelType::kU16}, {"int16", VoxelType::kI16},   {"uint32", VoxelType::kU32},
      {"int32", VoxelType::kI32},  {"float32", VoxelType::kF32}, {"float64", VoxelType::kF64}};
  if (field.isText())
    for (const auto& [name, type] : kTypes)
      if (field.text() == name) {
        array.type = type;
        return;
      }
  field.failExpected("bool, uint8, int8, uint16, int16, uint32, int32, float32 or float64");
}

std::endian byteOrderOf(const JsonField& codec) {
  const auto endian = settingOf(codec, "endian");
  if (!endian || endian->text() == "little") return std::endian::little;
  if (endian->text() != "big") endian->failExpected("little or big");
  return std::endian::big;
}

// "C", "F", or the array's axes in the order in which they are stored.
std::vector<size_t> transposed(const JsonField& codec, const std::vector<size_t>& before) {
  const JsonField field = requireSetting(codec, "order");
  std::vector<size_t> after = before;
  if (field.isText() && field.text() == "C") return after;
  if (field.isText() && field.text() == "F") {
    std::reverse(after.begin(), after.end());
    return after;
  }
  if (!field.isArray() || field.size() != before.size())
    field.failExpected(fmt::format("an order of {} axes", before.size()));
  std::vector<bool> is_taken(before.size(), false);
  for (size_t i = 0; i < before.size(); ++i) {
    const int64_t axis = field[i].whole();
    if (axis < 0 || axis >= static_cast<int64_t>(before.size()) ||
        is_taken[static_cast<size_t>(axis)])
      field.failExpected(fmt::format("each axis from 0 to {} once", before.size() - 1));
    is_taken[static_cast<size_t>(axis)] = true;
    after[i] = before[static_cast<size_t>(axis)];
  }
  return after;
}

std::optional<ZarrCodec> compressorOf(const std::string& name) {
  constexpr std::pair<const char*, ZarrCodec> kCompressors[] = {
      {"blosc", ZarrCodec::kBlosc},
      {"gzip", ZarrCodec::kDeflate},
      {"zlib", ZarrCodec::kDeflate},
      {"numcodecs.zlib", ZarrCodec::kDeflate},
      {"zstd", ZarrCodec::kZstd}};
  for (const auto& [known, codec] : kCompressors)
    if (name == known) return codec;
  return std::nullopt;
}

// A list of codecs: transpose, the array's bytes, one compressor, crc32c; or a shard.
class CodecList {
 public:
  CodecList(ZarrArray& array, bool is_in_shard) : array_(array), is_in_shard_(is_in_shard) {}

  void take(const JsonField& list) {
    if (!list.isArray() || list.size() == 0) list.failExpected("a list of codecs");
    for (size_t i = 0; i < list.size(); ++i) add(list[i]);
    if (!has_bytes_) list.failExpected("the codec bytes or sharding_indexed among them");
  }

 private:
  void add(const JsonField& codec) {
    // The list is a pipeline from array to bytes (Zarr 3, section Codecs): its order is checked.
    const std::string name = nameOf(codec);
    if (name == "transpose" && !has_bytes_) {
      array_.order = transposed(codec, array_.order);
      is_transposed_ = true;
    } else if (name == "bytes" && !has_bytes_) {
      has_bytes_ = true;
      array_.byte_order = byteOrderOf(codec);
      // Shards in shards, or around transposed arrays, are allowed but not read.
    } else if (name == "sharding_indexed" && !has_bytes_ && !is_transposed_ && !is_in_shard_) {
      has_bytes_ = is_shard_ = true;
      shard(codec);
    } else if (const auto compressor = compressorOf(name); compressor && has_bytes_ && !is_shard_ &&
                                                           !array_.has_crc &&
                                                           array_.codec == ZarrCodec::kNone) {
      array_.codec = *compressor;
    } else if (name == "crc32c" && has_bytes_ && !is_shard_ && !array_.has_crc) {
      array_.has_crc = true;
    } else {
      codec.failExpected(
          "transpose, bytes, one of blosc, gzip, zlib and zstd, and crc32c, in this order, or "
          "sharding_indexed around these");
    }
  }

  void shard(const JsonField& codec) {
    const JsonField extents = requireSetting(codec, "chunk_shape");
    array_.chunks = zarrExtents(extents, array_);
    for (size_t a = 0; a < array_.axes(); ++a)
      if (array_.files[a] % array_.chunks[a] != 0)
        extents.failExpected("chunks of which a whole number makes a shard");
    // The index of a shard is held whole.
    int64_t count = 1;
    for (size_t a = 0; a < array_.axes(); ++a)
      if (__builtin_mul_overflow(count, array_.files[a] / array_.chunks[a], &count) ||
          count > kMostChunksAFile)
        extents.failExpected(fmt::format("at most {} chunks a shard", kMostChunksAFile));
    // Codecs inside are of the chunks; those outside would be of whole shards.
    CodecList(array_, true).take(requireSetting(codec, "codecs"));
    array_.shards = indexOf(codec);
  }

  static ZarrShardIndex indexOf(const JsonField& codec) {
    ZarrShardIndex index;
    if (const auto at = settingOf(codec, "index_location")) {
      if (at->text() != "start" && at->text() != "end") at->failExpected("start or end");
      index.is_first = at->text() == "start";
    }
    const JsonField list = requireSetting(codec, "index_codecs");
    // Its length must be known to find it at a file's end, so that it cannot be compressed.
    const bool is_known = list.isArray() && (list.size() == 1 || list.size() == 2) &&
                          nameOf(list[0]) == "bytes" &&
                          (list.size() == 1 || nameOf(list[1]) == "crc32c");
    if (!is_known) list.failExpected("the codec bytes, and perhaps crc32c");
    index.byte_order = byteOrderOf(list[0]);
    index.has_crc = list.size() == 2;
    return index;
  }

  ZarrArray& array_;
  const bool is_in_shard_;
  bool has_bytes_ = false, is_shard_ = false, is_transposed_ = false;
};

void setKeys(const JsonField& encoding, ZarrArray& array) {
  const std::string name = nameOf(encoding);
  if (name != "default" && name != "v2") encoding.failExpected("default or v2");
  // Zarr 3, chunk key encodings: "c/0/0/0", or "0.0.0" as in version 2.
  array.prefix = name == "default" ? "c" : "";
  array.separator = name == "default" ? '/' : '.';
  if (const auto separator = settingOf(encoding, "separator")) {
    if (separator->text() != "." && separator->text() != "/") separator->failExpected("'.' or '/'");
    array.separator = separator->text()[0];
  }
}

// Extensions that need not be understood say so.
void checkUnknownMembers(const nlohmann::json& document, const JsonField& root,
                         const std::string& path, ZarrArray& array) {
  constexpr std::array<std::string_view, 12> kKnown = {"zarr_format",     "node_type",
                                                       "shape",           "data_type",
                                                       "chunk_grid",      "chunk_key_encoding",
                                                       "fill_value",      "codecs",
                                                       "attributes",      "storage_transformers",
                                                       "dimension_names", "consolidated_metadata"};
  std::vector<std::string> unknown;
  for (const auto& [name, value] : document.items()) {
    if (std::find(kKnown.begin(), kKnown.end(), name) != kKnown.end()) continue;
    unknown.push_back(name);
    const JsonField field = root.require(name.c_str());
    const auto must = field.isObject() ? field.find("must_understand") : std::nullopt;
    // Zarr 3: an unknown member has to be refused unless it says otherwise.
    if (!must || must->flag()) field.failExpected("no such extension");
  }
  if (!unknown.empty()) array.notes.push_back(unknownFieldsNote(path, unknown));
}

}  // namespace

bool isZarrArray(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  const JsonField type = root.require("node_type");
  if (type.text() != "array" && type.text() != "group") type.failExpected("array or group");
  return type.text() == "array";
}

ZarrArray parseZarrArray3(const JsonField& root, const nlohmann::json& document,
                          const std::string& path) {
  const JsonField node = root.require("node_type");
  if (node.text() != "array") node.failExpected("array");
  ZarrArray array;
  array.shape = zarrExtents(root.require("shape"));
  setDataType(root.require("data_type"), array);
  const JsonField grid = root.require("chunk_grid");
  if (nameOf(grid) != "regular") grid.failExpected("a regular grid of chunks");
  const JsonField extents = requireSetting(grid, "chunk_shape");
  array.chunks = array.files = zarrExtents(extents, array);
  array.order.resize(array.axes());
  std::iota(array.order.begin(), array.order.end(), size_t{0});
  setKeys(root.require("chunk_key_encoding"), array);
  CodecList(array, false).take(root.require("codecs"));
  requireZarrSizes(root.require("shape"), extents, array);
  array.fill_value = zarrFill(root.require("fill_value"), array);
  if (const auto more = root.find("storage_transformers"); more && !more->isNull())
    if (more->size() > 0) more->failExpected("no storage transformers, as none are read");
  checkUnknownMembers(document, root, path, array);
  return array;
}

}  // namespace sluice
