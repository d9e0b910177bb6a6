#include "io/zarr/zarr_array.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "io/headers/header_fields.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/values/vec.h"

namespace sluice {
namespace {

constexpr int64_t kMostVoxels = int64_t{1} << 59;  // times 8 bytes: 2^62

std::vector<int64_t> extents(const JsonField& field) {
  const size_t axes = field.size();
  if (axes < 1 || axes > kMostZarrAxes) field.failExpected("the extents of 1 to 5 axes");
  std::vector<int64_t> found;
  for (size_t a = 0; a < axes; ++a) {
    found.push_back(field[a].whole());
    if (found.back() < 1) field[a].failExpected("an extent of 1 or more");
  }
  return found;
}

// nullopt when the product is beyond `most`.
std::optional<int64_t> product(const std::vector<int64_t>& factors, int64_t most) {
  int64_t result = 1;
  for (const int64_t factor : factors)
    if (__builtin_mul_overflow(result, factor, &result) || result > most) return std::nullopt;
  return result;
}

void setType(const JsonField& field, ZarrArray& array) {
  constexpr const char* kExpected =
      "a type of <, > or | and u1, u2, u4, i1, i2, i4, f4, f8 or b1, such as \"<u2\"";
  if (!field.isText() || field.text().size() != 3) field.failExpected(kExpected);
  const std::string& text = field.text();
  const std::string brief = text.substr(1);
  constexpr std::pair<const char*, VoxelType> kTypes[] = {
      {"u1", VoxelType::kU8},  {"i1", VoxelType::kI8},  {"u2", VoxelType::kU16},
      {"i2", VoxelType::kI16}, {"u4", VoxelType::kU32}, {"i4", VoxelType::kI32},
      {"f4", VoxelType::kF32}, {"f8", VoxelType::kF64}, {"b1", VoxelType::kU8}};
  for (const auto& [name, type] : kTypes) {
    if (brief != name) continue;
    const bool one_byte = brief[1] == '1';
    if (text[0] != '<' && text[0] != '>' && !(one_byte && text[0] == '|')) break;
    array.type = type;
    array.byte_order = text[0] == '>' ? std::endian::big : std::endian::little;
    return;
  }
  field.failExpected(kExpected);
}

void setCodec(const JsonField& field, ZarrArray& array) {
  if (field.isNull()) return;
  const JsonField id = field.require("id");
  const std::string& name = id.text();
  if (name == "blosc")
    array.codec = ZarrCodec::kBlosc;
  else if (name == "zlib" || name == "gzip")
    array.codec = ZarrCodec::kDeflate;
  else if (name == "zstd")
    array.codec = ZarrCodec::kZstd;
  else
    id.failExpected("blosc, zlib, gzip, zstd or null");
}

double floatFill(const JsonField& field) {
  if (!field.isText()) return field.number();
  const std::string& text = field.text();
  if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (text == "Infinity") return std::numeric_limits<double>::infinity();
  if (text == "-Infinity") return -std::numeric_limits<double>::infinity();
  field.failExpected("a number, NaN, Infinity or -Infinity");
}

void setFill(const JsonField& field, ZarrArray& array) {
  if (field.isNull()) return;
  array.fill_value = visitVoxelType(array.type, [&](auto tag) -> double {
    using T = decltype(tag);
    if constexpr (std::is_floating_point_v<T>) {
      const double value = floatFill(field);
      if (std::isfinite(value) && std::abs(value) > double{std::numeric_limits<T>::max()})
        field.failExpected("a fill value that the type holds");
      return static_cast<double>(static_cast<T>(value));
    } else {
      // false and true of a bool array; texts are of floats alone.
      const double value = field.isFlag() ? (field.flag() ? 1.0 : 0.0) : field.number();
      if (!(value >= double{std::numeric_limits<T>::min()} &&
            value <= double{std::numeric_limits<T>::max()}) ||
          value != std::floor(value))
        field.failExpected("a fill value that the type holds");
      return value;
    }
  });
}

// A misspelt 'dimension_separator' would make every chunk a missing one.
void noteUnknownMembers(const nlohmann::json& document, const std::string& path, ZarrArray& array) {
  constexpr std::array<std::string_view, 9> kKnown = {
      "zarr_format", "shape",      "chunks",
      "dtype",       "compressor", "fill_value",
      "order",       "filters",    "dimension_separator"};
  std::vector<std::string> unknown;
  for (const auto& [name, value] : document.items())
    if (std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end()) unknown.push_back(name);
  if (!unknown.empty()) array.notes.push_back(unknownFieldsNote(path, unknown));
}

}  // namespace

uint64_t ZarrArray::chunkBytes() const {
  uint64_t bytes = bytesPerVoxel(type);
  for (const int64_t extent : chunks) bytes *= static_cast<uint64_t>(extent);
  return bytes;
}

int64_t ZarrArray::chunksAlong(size_t axis) const {
  return ceilDiv(shape[axis], chunks[axis]);
}

int64_t ZarrArray::chunkCount() const {
  int64_t count = 1;
  for (size_t a = 0; a < axes(); ++a) count *= chunksAlong(a);
  return count;
}

int64_t ZarrArray::chunkNumber(std::span<const int64_t> index) const {
  int64_t number = 0;
  for (size_t a = 0; a < axes(); ++a) number = number * chunksAlong(a) + index[a];
  return number;
}

std::vector<int64_t> ZarrArray::chunkIndex(int64_t number) const {
  std::vector<int64_t> index(axes());
  for (size_t a = axes(); a-- > 0;) {
    index[a] = number % chunksAlong(a);
    number /= chunksAlong(a);
  }
  return index;
}

std::string ZarrArray::chunkName(int64_t number) const {
  std::string name;
  for (const int64_t i : chunkIndex(number)) {
    if (!name.empty()) name += separator;
    name += std::to_string(i);
  }
  return name;
}

ZarrArray parseZarrArray(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  const JsonField version = root.require("zarr_format");
  if (version.whole() != 2) version.failExpected("Zarr version 2");
  ZarrArray array;
  array.shape = extents(root.require("shape"));
  array.chunks = extents(root.require("chunks"));
  if (array.chunks.size() != array.axes())
    root.require("chunks").failExpected(fmt::format("{} extents, as in shape", array.axes()));
  setType(root.require("dtype"), array);
  if (!product(array.shape, kMostVoxels)) root.require("shape").failExpected("at most 2^59 voxels");
  const auto most = static_cast<int64_t>(kMostChunkBytes / bytesPerVoxel(array.type));
  if (!product(array.chunks, most))
    root.require("chunks").failExpected(fmt::format("at most {} voxels a chunk", most));
  setCodec(root.require("compressor"), array);
  setFill(root.require("fill_value"), array);
  const JsonField order = root.require("order");
  if (order.text() != "C" && order.text() != "F") order.failExpected("C or F");
  array.fortran_order = order.text() == "F";
  if (const auto filters = root.find("filters"); filters && !filters->isNull()) {
    if (filters->size() > 0) filters->failExpected("null or no filters, as none are read");
  }
  if (const auto separator = root.find("dimension_separator"); separator) {
    if (separator->text() != "." && separator->text() != "/") separator->failExpected("'.' or '/'");
    array.separator = separator->text()[0];
  }
  noteUnknownMembers(document, path, array);
  return array;
}

}  // namespace sluice
