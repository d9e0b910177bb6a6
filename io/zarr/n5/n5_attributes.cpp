#include "io/zarr/n5/n5_attributes.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "io/files/length_unit.h"
#include "io/zarr/metadata/zarr_array_fields.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {
namespace {

VoxelType n5TypeOf(const JsonField& field) {
  constexpr std::pair<const char*, VoxelType> kTypes[] = {
      {"uint8", VoxelType::kU8},    {"int8", VoxelType::kI8},    {"uint16", VoxelType::kU16},
      {"int16", VoxelType::kI16},   {"uint32", VoxelType::kU32}, {"int32", VoxelType::kI32},
      {"float32", VoxelType::kF32}, {"float64", VoxelType::kF64}};
  if (field.isText())
    for (const auto& [name, type] : kTypes)
      if (field.text() == name) return type;
  field.failExpected("uint8, int8, uint16, int16, uint32, int32, float32 or float64");
}

ZarrCodec n5CodecOf(const JsonField& root) {
  // Version 1 has the name alone.
  const auto compression = root.find("compression");
  const JsonField name =
      compression ? compression->require("type") : root.require("compressionType");
  constexpr std::pair<const char*, ZarrCodec> kCodecs[] = {{"raw", ZarrCodec::kNone},
                                                           {"gzip", ZarrCodec::kDeflate},
                                                           {"zstd", ZarrCodec::kZstd},
                                                           {"xz", ZarrCodec::kXz},
                                                           {"blosc", ZarrCodec::kBlosc}};
  for (const auto& [known, codec] : kCodecs)
    if (name.text() == known) return codec;
  name.failExpected("the compression raw, gzip, zstd, xz or blosc, as others are not read");
}

template <class T>
void reverse(std::vector<T>& values) {
  std::reverse(values.begin(), values.end());
}

// A number for each of 1 to 5 axes.
std::vector<double> perAxis(const JsonField& field) {
  const size_t count = field.size();
  if (count < 1 || count > kMostZarrAxes) field.failExpected("a number for each of 1 to 5 axes");
  std::vector<double> found;
  for (size_t i = 0; i < count; ++i) found.push_back(field[i].number());
  return found;
}

std::vector<std::string> texts(const JsonField& field) {
  if (field.isText()) return {field.text()};
  const size_t count = field.size();
  if (count > kMostZarrAxes) field.failExpected("a text for each of 1 to 5 axes");
  std::vector<std::string> found;
  for (size_t i = 0; i < count; ++i) found.push_back(field[i].text());
  return found;
}

std::vector<std::vector<double>> factorsIn(const JsonField& field) {
  if (!field.isArray() || field.size() == 0)
    field.failExpected("factors along the axes, or a list of them");
  if (!field[0].isArray()) return {perAxis(field)};
  constexpr size_t kMostLevels = 64;
  if (field.size() > kMostLevels) field.failExpected("at most 64 levels");
  std::vector<std::vector<double>> found;
  for (size_t i = 0; i < field.size(); ++i) found.push_back(perAxis(field[i]));
  return found;
}

// COSEM's transform counts axes from the slowest.
void setTransform(const JsonField& transform, N5Place& place) {
  if (const auto scale = transform.find("scale")) place.resolution = perAxis(*scale);
  if (const auto translate = transform.find("translate")) place.translation = perAxis(*translate);
  if (const auto axes = transform.find("axes")) place.axes = texts(*axes);
  if (const auto units = transform.find("units")) place.units = texts(*units);
  reverse(place.resolution);
  reverse(place.translation);
  reverse(place.axes);
  reverse(place.units);
}

// A number for each axis; those of space alone go on with `fill`. Empty: none are given.
std::vector<double> fitted(std::vector<double> numbers, size_t axes, double fill,
                           const std::string& path) {
  constexpr size_t kSpace = 3;
  if (numbers.empty() || numbers.size() == axes) return numbers;
  if (numbers.size() != kSpace || axes < kSpace)
    fail("{}: expected a resolution and factors of {} numbers, as the data set has axes, found {}",
         path, axes, numbers.size());
  numbers.resize(axes, fill);
  return numbers;
}

std::vector<ZarrAxis> namedAxes(const N5Place& place, size_t axes, const std::string& path) {
  constexpr const char* kNames[] = {"x", "y", "z", "c", "t"};
  std::vector<ZarrAxis> named;
  if (!place.axes.empty() && place.axes.size() != axes)
    fail("{}: expected {} axes, as the data set has, found {}", path, axes, place.axes.size());
  // Names alone tell which of more axes are channels or time.
  if (place.axes.empty() && (place.units.empty() || axes != 3)) return named;
  for (size_t a = 0; a < axes; ++a) {
    ZarrAxis& axis = named.emplace_back();
    axis.name = place.axes.empty() ? kNames[a] : place.axes[a];
    if (!place.units.empty())
      axis.unit = lengthUnit(place.units[std::min(a, place.units.size() - 1)]);
  }
  reverse(named);
  return named;
}

}  // namespace

bool isN5Array(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  return document.is_object() && document.contains("dimensions");
}

ZarrArray parseN5Array(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  ZarrArray array;
  const JsonField dimensions = root.require("dimensions"), blocks = root.require("blockSize");
  array.shape = zarrExtents(dimensions);
  array.chunks = zarrExtents(blocks, array);
  array.type = n5TypeOf(root.require("dataType"));
  requireZarrSizes(dimensions, blocks, array);
  // N5 names the fastest axis first, Zarr the slowest.
  reverse(array.shape);
  reverse(array.chunks);
  array.files = array.chunks;
  array.codec = n5CodecOf(root);
  array.order.resize(array.axes());
  std::iota(array.order.begin(), array.order.end(), size_t{0});
  // N5 stores big-endian numbers always.
  array.byte_order = std::endian::big;
  array.separator = '/';
  array.is_n5 = true;
  return array;
}

N5Place parseN5Place(std::string_view text, const std::string& path) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  N5Place place;
  for (const char* key : {"downsamplingFactors", "scales"})
    if (const auto field = root.find(key); field && !field->isNull())
      place.factors = factorsIn(*field);
  if (const auto transform = root.find("transform"); transform && transform->isObject())
    setTransform(*transform, place);
  // n5-viewer writes "pixelResolution", Paintera "resolution".
  for (const char* key : {"pixelResolution", "resolution"}) {
    const auto field = root.find(key);
    if (!field || field->isNull()) continue;
    place.resolution = perAxis(field->isObject() ? field->require("dimensions") : *field);
    if (!field->isObject()) continue;
    if (const auto unit = field->find("unit"); unit && unit->isText()) place.units = {unit->text()};
  }
  if (const auto axes = root.find("axes"); axes && axes->isArray()) place.axes = texts(*axes);
  for (const char* key : {"unit", "units"})
    if (const auto units = root.find(key); units && !units->isNull()) place.units = texts(*units);
  return place;
}

ZarrImage n5Image(const N5Place& group, const std::vector<N5Place>& levels, size_t axes,
                  const std::string& path) {
  const auto firstOf = [&](const std::vector<double>& a, const std::vector<double>& b,
                           double otherwise, double fill) {
    std::vector<double> found = fitted(a.empty() ? b : a, axes, fill, path);
    if (found.empty()) found.assign(axes, otherwise);
    return found;
  };
  const N5Place& finest = levels[0];
  const std::vector<double> base = firstOf(group.resolution, finest.resolution, 1, 1);
  const std::vector<double> first = firstOf(finest.translation, group.translation, 0, 0);
  const size_t count = group.factors.size() > 1 ? group.factors.size() : levels.size();

  ZarrImage image;
  for (size_t i = 0; i < count; ++i) {
    image.levels.push_back(n5LevelName(i));
    ZarrPlace& place = image.places.emplace_back();
    const N5Place own = i < levels.size() ? levels[i] : N5Place();
    std::vector<double> factor;
    if (i == 0)
      factor.assign(axes, 1);
    else if (i < group.factors.size())
      factor = fitted(group.factors[i], axes, 1, path);
    else if (own.factors.size() == 1)
      factor = fitted(own.factors[0], axes, 1, path);
    if (factor.empty()) place.scale = fitted(own.resolution, axes, 1, path);
    for (size_t a = 0; a < factor.size(); ++a) place.scale.push_back(base[a] * factor[a]);
    const std::vector<double> translation = fitted(own.translation, axes, 0, path);
    // A coarser voxel is the mean of a block, whose middle lies half of the difference further.
    for (size_t a = 0; a < place.scale.size(); ++a)
      place.translation.push_back(!translation.empty() ? translation[a]
                                                       : first[a] + (place.scale[a] - base[a]) / 2);
    place.is_translated = true;
    reverse(place.scale);
    reverse(place.translation);
  }
  // If the numbers of a level are missing, the voxels have to show where all levels lie.
  if (std::any_of(image.places.begin(), image.places.end(),
                  [](const ZarrPlace& place) { return place.scale.empty(); })) {
    std::fill(image.places.begin() + 1, image.places.end(), ZarrPlace());
    image.places[0].is_translated = false;
  }
  N5Place names = group;
  if (names.axes.empty()) names.axes = finest.axes;
  if (names.units.empty()) names.units = finest.units;
  image.axes = namedAxes(names, axes, path);
  image.scale = image.places[0].scale;
  image.translation = image.places[0].translation;
  image.frame = WorldFrame::kPictureRows;
  return image;
}

std::string n5LevelName(size_t level) {
  return "s" + std::to_string(level);
}

}  // namespace sluice
