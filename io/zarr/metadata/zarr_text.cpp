#include "io/zarr/metadata/zarr_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "io/zarr/metadata/zarr_image.h"

namespace sluice {
namespace {

using nlohmann::ordered_json;

std::string dtype(const ZarrArray& array) {
  const std::string_view brief = name(array.type);  // "u16"
  const size_t bytes = bytesPerVoxel(array.type);
  const char order = bytes == 1 ? '|' : array.byte_order == std::endian::big ? '>' : '<';
  return std::string(1, order) + brief[0] + std::to_string(bytes);
}

ordered_json fillValue(const ZarrArray& array) {
  if (array.type != VoxelType::kF32 && array.type != VoxelType::kF64)
    // A double would be written as "0.0".
    return static_cast<int64_t>(array.fill_value);
  // JSON has no such numbers; both versions of Zarr name these texts.
  if (std::isnan(array.fill_value)) return "NaN";
  if (std::isinf(array.fill_value)) return array.fill_value > 0 ? "Infinity" : "-Infinity";
  return array.fill_value;
}

ordered_json axis(const std::string& name, const char* type, const std::string& unit) {
  ordered_json result{{"name", name}, {"type", type}};
  if (!unit.empty()) result["unit"] = unit;
  return result;
}

ordered_json ownPart(const VolumeLayout& layout) {
  ordered_json own = ordered_json::object();
  const std::array<Vec3d, 3> straight{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (layout.axes != straight)
    for (const Vec3d& a : layout.axes) own["axes"].push_back({a.x, a.y, a.z});
  if (layout.value_scale != 1 || layout.value_offset != 0) {
    own["value_scale"] = layout.value_scale;
    own["value_offset"] = layout.value_offset;
  }
  if (layout.name.ends_with("(level set)")) own["level_set"] = true;
  if (layout.frame != WorldFrame::kPictureRows) own["frame"] = zarrFrameName(layout.frame);
  return own;
}

std::string hexOf(const std::array<double, 3>& color) {
  std::string text;
  for (const double part : color) text += fmt::format("{:02X}", std::lround(255 * part));
  return text;
}

// The window in the form that viewers expect: with the limits that they had, or else those of the
// values.
ordered_json windowOf(const StoredLook& look, const VolumeLayout& layout) {
  const ValueRange window = *look.window;
  ValueRange limits = layout.stored_range.value_or(window);
  visitVoxelType(layout.type, [&](auto tag) {
    using T = decltype(tag);
    if constexpr (std::is_integral_v<T>)
      limits = {static_cast<double>(std::numeric_limits<T>::min()),
                static_cast<double>(std::numeric_limits<T>::max())};
  });
  limits = look.limits.value_or(limits);
  return {{"min", limits.lo}, {"max", limits.hi}, {"start", window.lo}, {"end", window.hi}};
}

// Names and colours of the channels in viewers, until the user chooses others. A channel without a
// colour gets none, so that sluice draws the store in the default colours, as it draws its source.
ordered_json omero(const ZarrChannelsText& text, const VolumeLayout& layout) {
  const std::vector<std::string>& names = text.names;
  ordered_json channels = ordered_json::array();
  for (size_t c = 0; c < names.size(); ++c) {
    const bool has_look = c < text.looks.size();
    const StoredLook look = has_look ? text.looks[c] : StoredLook();
    channels.push_back({{"label", names[c].empty() ? fmt::format("channel {}", c) : names[c]},
                        {"active", look.is_active}});
    if (look.color) channels.back()["color"] = hexOf(*look.color);
    if (look.is_inverted) channels.back()["inverted"] = true;
    if (look.window) channels.back()["window"] = windowOf(look, layout);
  }
  return {{"channels", channels}};
}

}  // namespace

namespace {

std::string dataType(VoxelType type) {
  switch (type) {
    case VoxelType::kF32:
      return "float32";
    case VoxelType::kF64:
      return "float64";
    default:
      return fmt::format("{}int{}", name(type)[0] == 'u' ? "u" : "", 8 * bytesPerVoxel(type));
  }
}

ordered_json codec(const char* name, ordered_json configuration = nullptr) {
  ordered_json result{{"name", name}};
  if (!configuration.is_null()) result["configuration"] = std::move(configuration);
  return result;
}

ordered_json bytesCodec(std::endian order) {
  return codec("bytes", {{"endian", order == std::endian::big ? "big" : "little"}});
}

// The scaling of the values as the CF conventions have it.
ordered_json scaleAttributes(const ZarrArrayLabels& labels) {
  ordered_json attributes = ordered_json::object();
  if (labels.value_scale == 1 && labels.value_offset == 0) return attributes;
  attributes["scale_factor"] = labels.value_scale;
  attributes["add_offset"] = labels.value_offset;
  return attributes;
}

// The zarr.json of an array of shards.
std::string shardedArrayText(const ZarrArray& array, const BloscOptions& options,
                             const ZarrArrayLabels& labels) {
  constexpr std::array<const char*, 3> kShuffles = {"noshuffle", "shuffle", "bitshuffle"};
  const size_t voxel_bytes = bytesPerVoxel(array.type);
  ordered_json inside = ordered_json::array();
  inside.push_back(bytesCodec(array.byte_order));
  inside.push_back(codec(
      "blosc", {{"cname", options.codec == BloscCodec::kLz4 ? "lz4" : "zstd"},
                {"clevel", options.level},
                {"shuffle", kShuffles[static_cast<size_t>(bloscShuffle(voxel_bytes, options))]},
                {"typesize", voxel_bytes},
                {"blocksize", kBloscBlockBytes}}));
  inside.push_back(codec("crc32c"));
  ordered_json index = ordered_json::array();
  index.push_back(bytesCodec(array.shards->byte_order));
  index.push_back(codec("crc32c"));
  ordered_json codecs = ordered_json::array();
  codecs.push_back(codec("sharding_indexed", {{"chunk_shape", array.chunks},
                                              {"codecs", inside},
                                              {"index_codecs", index},
                                              {"index_location", "end"}}));
  ordered_json text{{"zarr_format", 3}, {"node_type", "array"}};
  text["shape"] = array.shape;
  text["data_type"] = dataType(array.type);
  text["chunk_grid"] = codec("regular", {{"chunk_shape", array.files}});
  text["chunk_key_encoding"] = codec("default", {{"separator", std::string(1, array.separator)}});
  text["fill_value"] = fillValue(array);
  text["codecs"] = codecs;
  // OME-Zarr 0.5 requires the names of the image's axes here, too.
  if (!labels.axes.empty()) text["dimension_names"] = labels.axes;
  text["attributes"] = scaleAttributes(labels);
  return text.dump(2) + "\n";
}

}  // namespace

std::string zarrGroupText(ZarrFormat format) {
  ordered_json text{{"zarr_format", format == ZarrFormat::k3 ? 3 : 2}};
  if (format == ZarrFormat::k3) text["node_type"] = "group";
  return text.dump(2) + "\n";
}

ZarrArrayTexts zarrArrayTexts(const ZarrArray& array, const BloscOptions& options,
                              const ZarrArrayLabels& labels) {
  if (array.shards) return {shardedArrayText(array, options, labels), ""};
  const ordered_json compressor{{"id", "blosc"},
                                {"cname", options.codec == BloscCodec::kLz4 ? "lz4" : "zstd"},
                                {"clevel", options.level},
                                {"shuffle", bloscShuffle(bytesPerVoxel(array.type), options)},
                                {"blocksize", kBloscBlockBytes}};
  const ordered_json header{{"zarr_format", 2},
                            {"shape", array.shape},
                            {"chunks", array.chunks},
                            {"dtype", dtype(array)},
                            {"compressor", compressor},
                            {"fill_value", fillValue(array)},
                            {"order", "C"},
                            {"filters", nullptr},
                            {"dimension_separator", std::string(1, array.separator)}};
  ZarrArrayTexts texts{header.dump(2) + "\n", ""};
  ordered_json attributes = scaleAttributes(labels);
  if (!attributes.empty()) {
    attributes["_ARRAY_DIMENSIONS"] = labels.axes;
    texts.attributes = attributes.dump(2) + "\n";
  }
  return texts;
}

std::vector<std::string> zarrAxisNames(const VolumeLayout& layout, size_t channels) {
  std::vector<std::string> names;
  if (layout.time_steps > 1) names.emplace_back("t");
  if (channels > 1) names.emplace_back("c");
  names.insert(names.end(), {"z", "y", "x"});
  return names;
}

std::string zarrImageText(const VolumeLayout& layout, const std::string& name,
                          const ZarrChannelsText& channels, const ZarrLevelsText& levels,
                          ZarrFormat format) {
  ordered_json axes = ordered_json::array();
  const TimeAxis times = levels.times.value_or(TimeAxis());
  std::vector<std::array<double, 2>> others;  // scale and place of axes that are not of space
  for (const std::string& name : zarrAxisNames(layout, channels.names.size())) {
    const bool is_time = name == "t", is_space = !is_time && name != "c";
    axes.push_back(axis(name,
                        is_time    ? "time"
                        : is_space ? "space"
                                   : "channel",
                        is_space  ? layout.unit
                        : is_time ? times.unit
                                  : ""));
    // OME-Zarr wants numbers for each axis, also for channels, which have no length.
    if (is_time) others.push_back({times.step, times.start});
    if (name == "c") others.push_back({1, 0});
  }
  ordered_json datasets = ordered_json::array();
  const auto addLevel = [&](const LevelPlacement& place) {
    ordered_json scale = ordered_json::array(), translation = ordered_json::array();
    for (const auto& [step, start] : others) {
      scale.push_back(step);
      translation.push_back(start);
    }
    for (int a = 2; a >= 0; --a) {
      scale.push_back(layout.spacing[a] * place.scale[a]);
      translation.push_back(layout.origin[a] + layout.spacing[a] * place.offset[a]);
    }
    datasets.push_back({{"path", std::to_string(datasets.size())},
                        {"coordinateTransformations",
                         {{{"type", "scale"}, {"scale", scale}},
                          {{"type", "translation"}, {"translation", translation}}}}});
  };
  addLevel({});
  for (const LevelPlacement& place : levels.placements) addLevel(place);
  const bool is_v3 = format == ZarrFormat::k3;
  ordered_json multiscale;
  // OME-Zarr 0.5 has the version beside the multiscales, 0.4 in each of them.
  if (!is_v3) multiscale["version"] = "0.4";
  multiscale["name"] = name;
  multiscale["axes"] = axes;
  multiscale["datasets"] = datasets;
  if (!levels.placements.empty()) multiscale["type"] = zarrLevelsName(levels.values);
  ordered_json image;
  if (is_v3) image["version"] = "0.5";
  image["multiscales"] = ordered_json::array({multiscale});
  const bool is_told =
      !channels.looks.empty() ||
      std::ranges::any_of(channels.names, [](const std::string& each) { return !each.empty(); });
  if (is_told) image["omero"] = omero(channels, layout);
  ordered_json own = ownPart(layout);
  if (levels.has_spreads) own["spreads"] = kZarrSpreadFolder;
  for (const LevelValues values : levels.groups)
    own["levels"][std::string(zarrLevelsName(values))] = zarrLevelsFolder(values);
  if (is_v3) {
    ordered_json attributes{{"ome", image}};
    if (!own.empty()) attributes["sluice"] = own;
    image = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", attributes}};
  } else if (!own.empty()) {
    image["sluice"] = own;
  }
  // A name need not be UTF-8.
  return image.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace sluice
