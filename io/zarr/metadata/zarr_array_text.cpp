#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "io/headers/header_fields.h"
#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_array_fields.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {
namespace {

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
  // Chunks are not compressed if it is null.
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

ZarrArray parseZarrArray2(const JsonField& root, const nlohmann::json& document,
                          const std::string& path) {
  ZarrArray array;
  array.shape = zarrExtents(root.require("shape"));
  // A file is a chunk if there are no shards.
  array.chunks = array.files = zarrExtents(root.require("chunks"), array);
  setType(root.require("dtype"), array);
  requireZarrSizes(root.require("shape"), root.require("chunks"), array);
  setCodec(root.require("compressor"), array);
  array.fill_value = zarrFill(root.require("fill_value"), array);
  const JsonField order = root.require("order");
  if (order.text() != "C" && order.text() != "F") order.failExpected("C or F");
  array.order.resize(array.axes());
  std::iota(array.order.begin(), array.order.end(), size_t{0});
  if (order.text() == "F") std::reverse(array.order.begin(), array.order.end());
  if (const auto filters = root.find("filters"); filters && !filters->isNull()) {
    if (filters->size() > 0) filters->failExpected("null or no filters, as none are read");
  }
  // Arrays that were written before the member existed have '.'.
  if (const auto separator = root.find("dimension_separator"); separator) {
    if (separator->text() != "." && separator->text() != "/") separator->failExpected("'.' or '/'");
    array.separator = separator->text()[0];
  }
  noteUnknownMembers(document, path, array);
  return array;
}

}  // namespace

ZarrArray parseZarrArray(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  const JsonField version = root.require("zarr_format");
  if (version.whole() == 2) return parseZarrArray2(root, document, path);
  if (version.whole() == 3) return parseZarrArray3(root, document, path);
  version.failExpected("Zarr version 2 or 3");
}

}  // namespace sluice
