#include "io/zarr/metadata/zarr_image.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "io/files/length_unit.h"
#include "io/headers/volume_description.h"
#include "io/zarr/metadata/cf_attributes.h"
#include "io/zarr/metadata/omero_channels.h"
#include "io/zarr/metadata/zarr_times.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

// A name in a message: one printable line.
std::string shown(const std::string& text) {
  return fmt::format("'{}'", printable(text));
}

std::vector<double> numbers(const JsonField& field) {
  std::vector<double> found;
  const size_t count = field.size();
  if (count > kMostZarrAxes) field.failExpected("a number for each axis");
  for (size_t i = 0; i < count; ++i) found.push_back(field[i].number());
  return found;
}

std::string textOr(const JsonField& object, const char* key) {
  const auto field = object.find(key);
  return field && !field->isNull() ? field->text() : std::string();
}

std::vector<ZarrAxis> parseAxes(const JsonField& field) {
  std::vector<ZarrAxis> axes;
  const size_t count = field.size();
  if (count > kMostZarrAxes) field.failExpected("at most 5 axes");
  for (size_t i = 0; i < count; ++i) {
    const JsonField axis = field[i];
    if (axis.isText())  // version 0.3
      axes.push_back({axis.text(), "", ""});
    else
      axes.push_back({axis.require("name").text(), textOr(axis, "type"), textOr(axis, "unit")});
  }
  return axes;
}

struct LevelWords {
  LevelValues values;
  const char *name, *folder;
};
constexpr LevelWords kLevelWords[] = {{LevelValues::kMeans, "mean", "mean"},
                                      {LevelValues::kMaxima, "max", "maximum"},
                                      {LevelValues::kMinima, "min", "minimum"},
                                      {LevelValues::kModes, "mode", "mode"}};
const LevelWords* wordsOf(LevelValues values) {
  const auto* const words = std::ranges::find(kLevelWords, values, &LevelWords::values);
  return words == std::end(kLevelWords) ? nullptr : words;
}

// Applies a list of transformations after those that are in `place` already.
void transform(const JsonField& list, ZarrPlace& place) {
  const size_t count = list.size();
  for (size_t i = 0; i < count; ++i) {
    const JsonField step = list[i];
    const std::string& type = step.require("type").text();
    if (type == "identity") continue;
    if (type == "sequence") {
      transform(step.require("transformations"), place);
      continue;
    }
    if (type != "scale" && type != "translation")
      step.require("type").failExpected("scale, translation, identity or a sequence of these");
    const JsonField values = step.require(type.c_str());
    const std::vector<double> by = numbers(values);
    if (place.scale.empty()) {
      place.scale.assign(by.size(), 1);
      place.translation.assign(by.size(), 0);
    }
    if (by.size() != place.scale.size())
      values.failExpected(fmt::format("{} numbers", place.scale.size()));
    for (size_t a = 0; a < by.size(); ++a) {
      if (type == "scale") {
        // Transformations apply one after the other (OME-Zarr 0.4): a scale moves what was moved
        // before.
        place.scale[a] *= by[a];
        place.translation[a] *= by[a];
      } else {
        place.translation[a] += by[a];
        place.is_translated = true;
      }
    }
  }
}

// Folders must be inside the image's, so that a store cannot refer to files elsewhere.
void requireInside(const JsonField& field) {
  const std::filesystem::path path(field.text());
  const bool outside = std::any_of(path.begin(), path.end(), [](const auto& part) {
    return part == ".." || part == "." || part.empty();
  });
  if (path.empty() || path.is_absolute() || outside ||
      field.text().find('\0') != std::string::npos || printable(field.text(), 4096) != field.text())
    field.failExpected("the path of a folder inside this one");
}

// The axes of version 0.6: those of the coordinate system that the first level's transformations
// lead to.
std::optional<JsonField> axesOfSystem(const JsonField& multiscale, const JsonField& datasets) {
  const auto systems = multiscale.find("coordinateSystems");
  if (!systems || systems->size() == 0) return std::nullopt;
  std::string wanted;
  if (const auto list = datasets[0].find("coordinateTransformations"); list && list->size() > 0)
    wanted = textOr((*list)[list->size() - 1], "output");
  for (size_t i = 0; i < systems->size(); ++i)
    if (wanted.empty() || textOr((*systems)[i], "name") == wanted)
      return (*systems)[i].find("axes");
  systems->failExpected(fmt::format("the coordinate system {}", shown(wanted)));
}

void parseMultiscale(const JsonField& multiscale, const std::string& level, ZarrImage& image) {
  const JsonField datasets = multiscale.require("datasets");
  auto axes = multiscale.find("axes");
  if (!axes && datasets.size() > 0) axes = axesOfSystem(multiscale, datasets);
  if (axes) image.axes = parseAxes(*axes);
  // Other writers have more words, such as "gaussian".
  if (const auto type = multiscale.find("type"); type && type->isText())
    for (const LevelWords& words : kLevelWords)
      if (type->text() == words.name) image.level_values = words.values;
  const size_t count = datasets.size();
  if (count == 0) datasets.failExpected("one level at least");
  constexpr size_t kMostLevels = 64;
  if (count > kMostLevels) datasets.failExpected(fmt::format("at most {} levels", kMostLevels));
  const auto of_all = multiscale.find("coordinateTransformations");
  std::optional<size_t> asked;
  for (size_t i = 0; i < count; ++i) {
    const JsonField path = datasets[i].require("path");
    requireInside(path);
    image.levels.push_back(path.text());
    if (!asked && (level.empty() || path.text() == level)) asked = i;
    ZarrPlace& place = image.places.emplace_back();
    if (const auto list = datasets[i].find("coordinateTransformations")) transform(*list, place);
    // A translation of all levels tells nothing about how they lie to each other.
    if (of_all) {
      const bool is_translated = place.is_translated;
      transform(*of_all, place);
      place.is_translated = is_translated;
    }
  }
  if (!asked) datasets.failExpected(fmt::format("the level {}", shown(level)));
  image.scale = image.places[*asked].scale;
  image.translation = image.places[*asked].translation;
}

Vec3d vector(const JsonField& field) {
  const std::vector<double> n = numbers(field);
  if (n.size() != 3) field.failExpected("3 numbers");
  return {n[0], n[1], n[2]};
}

constexpr std::pair<const char*, WorldFrame> kFrames[] = {{"none", WorldFrame::kNone},
                                                          {"ras", WorldFrame::kRas},
                                                          {"lps", WorldFrame::kLps},
                                                          {"picture", WorldFrame::kPictureRows},
                                                          {"y-up", WorldFrame::kYUp}};

WorldFrame parseFrame(const JsonField& field) {
  for (const auto& [name, frame] : kFrames)
    if (field.text() == name) return frame;
  field.failExpected("none, ras, lps, picture or y-up");
}

void parseOwn(const JsonField& own, ZarrImage& image) {
  if (const auto axes = own.find("axes")) {
    if (axes->size() != 3) axes->failExpected("3 directions");
    image.directions = {vector((*axes)[0]), vector((*axes)[1]), vector((*axes)[2])};
    for (const Vec3d& axis : *image.directions)
      if (!(std::abs(length(axis) - 1) < 1e-6)) axes->failExpected("directions of length 1");
  }
  if (const auto scale = own.find("value_scale")) image.value_scale = scale->number();
  if (const auto offset = own.find("value_offset")) image.value_offset = offset->number();
  if (const auto flag = own.find("level_set")) image.level_set = flag->flag();
  if (const auto spreads = own.find("spreads")) {
    requireInside(*spreads);
    image.spreads = spreads->text();
  }
  if (const auto groups = own.find("levels"))
    for (const LevelWords& words : kLevelWords)
      if (const auto folder = groups->find(words.name)) {
        requireInside(*folder);
        image.level_groups.push_back({words.values, folder->text()});
      }
  if (const auto frame = own.find("frame")) image.frame = parseFrame(*frame);
}

// `ome`: what OME-Zarr says of the image, `attributes` itself before version 0.5.
void parseAttributes(const JsonField& attributes, const JsonField& ome, const std::string& level,
                     ZarrImage& image) {
  if (const auto multiscales = ome.find("multiscales")) {
    if (multiscales->size() == 0) multiscales->failExpected("one image at least");
    parseMultiscale((*multiscales)[0], level, image);
  } else {
    if (const auto names = attributes.find("_ARRAY_DIMENSIONS")) image.axes = parseAxes(*names);
    parseCfAttributes(attributes, image);
  }
  if (const auto omero = ome.find("omero")) {
    image.channels = omeroNames(*omero);
    image.looks = omeroLooks(*omero);
    image.notes = omeroFaults(*omero);
  }
  if (const auto own = attributes.find("sluice")) parseOwn(*own, image);
}

// Dimensions may have null for a name.
bool areAllNamed(const JsonField& names) {
  if (names.isNull()) return false;
  for (size_t i = 0; i < names.size(); ++i)
    if (!names[i].isText() || names[i].text().empty()) return false;
  return true;
}

enum class Role { kX, kY, kZ, kTime, kChannel, kSomeSpace };

std::optional<Role> roleOf(const ZarrAxis& axis) {
  const std::string name = lowercase(axis.name);
  const bool space = axis.type.empty() || axis.type == "space";
  if (axis.type == "time" || (axis.type.empty() && (name == "t" || name == "time")))
    return Role::kTime;
  if (axis.type == "channel" || (axis.type.empty() && (name == "c" || name == "channel")))
    return Role::kChannel;
  if (space && name == "x") return Role::kX;
  if (space && name == "y") return Role::kY;
  if (space && name == "z") return Role::kZ;
  return space ? std::optional(Role::kSomeSpace) : std::nullopt;
}

std::vector<Role> rolesByName(const std::vector<ZarrAxis>& axes, const std::string& path) {
  std::vector<Role> roles;
  int64_t unnamed = 0;
  for (const ZarrAxis& axis : axes) {
    const auto role = roleOf(axis);
    if (!role)
      fail("{}: axis {} of type {}, expected x, y, z, time or channel", path, shown(axis.name),
           shown(axis.type));
    roles.push_back(*role);
    unnamed += *role == Role::kSomeSpace ? 1 : 0;
  }
  if (unnamed == 0) return roles;
  // If axes have other names, the last is x, as everywhere in this format.
  int next = 0;
  for (auto role = roles.rbegin(); role != roles.rend(); ++role)
    if (*role != Role::kTime && *role != Role::kChannel)
      *role = next < 3 ? static_cast<Role>(next++) : Role::kSomeSpace;
  return roles;
}

std::vector<Role> rolesByNumber(size_t axes, bool channel_wanted) {
  switch (axes) {
    case 3:
      return {Role::kZ, Role::kY, Role::kX};
    case 4:
      return {channel_wanted ? Role::kChannel : Role::kTime, Role::kZ, Role::kY, Role::kX};
    default:
      return {Role::kTime, Role::kChannel, Role::kZ, Role::kY, Role::kX};
  }
}

void place(const ZarrImage& image, const std::string& path, ZarrView& view) {
  const auto unitOf = [&](size_t a) {
    return image.axes.empty() ? std::string() : lengthUnit(image.axes[view.space[a]].unit);
  };
  view.layout.unit = unitOf(0);
  // x, y and z of numbers for each axis, in the unit of x.
  const auto inSpace = [&](const std::vector<double>& of_axes) {
    Vec3d of_space;
    for (size_t a = 0; a < 3; ++a)
      of_space[static_cast<int>(a)] =
          of_axes[view.space[a]] * unitRatio(unitOf(a), view.layout.unit);
    return of_space;
  };
  Vec3d scale{1, 1, 1}, origin;
  if (!image.scale.empty()) {
    scale = inSpace(image.scale);
    origin = inSpace(image.translation);
  }
  const std::array<Vec3d, 3> directions =
      image.directions.value_or(std::array<Vec3d, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  // Our own directions turn the way from level 0's first voxel to this one's, too.
  if (image.directions && !image.places.empty() && !image.places[0].translation.empty() &&
      image.places[0].translation.size() == image.scale.size()) {
    const Vec3d finest = inSpace(image.places[0].translation);
    const Vec3d along = origin - finest;
    origin = finest + directions[0] * along.x + directions[1] * along.y + directions[2] * along.z;
  }
  VolumeLayout& layout = view.layout;
  setSteps(path, {directions[0] * scale.x, directions[1] * scale.y, directions[2] * scale.z},
           layout);
  for (int a = 0; a < 3; ++a) {  // to the last bit as they were written
    layout.spacing[a] = std::abs(scale[a]);
    layout.axes[static_cast<size_t>(a)] =
        scale[a] < 0 ? -directions[static_cast<size_t>(a)] : directions[static_cast<size_t>(a)];
  }
  setOrigin(path, origin, layout);
  placeSteps(image, path, view);
  setValueScale(path, image.value_scale, image.value_offset, layout);
}

}  // namespace

std::string_view zarrLevelsName(LevelValues values) {
  const LevelWords* const words = wordsOf(values);
  return words == nullptr ? std::string_view() : words->name;
}

std::string_view zarrLevelsFolder(LevelValues values) {
  const LevelWords* const words = wordsOf(values);
  return words == nullptr ? std::string_view() : words->folder;
}

std::string_view zarrFrameName(WorldFrame frame) {
  for (const auto& [name, known] : kFrames)
    if (known == frame) return name;
  return "none";
}

ZarrImage parseZarrImage(std::string_view text, const std::string& path, const std::string& level) {
  const nlohmann::json document = parseJson(text, path);
  const JsonField root(document, path);
  ZarrImage image;
  if (!root.find("node_type")) {
    parseAttributes(root, root, level, image);
    return image;
  }
  // A zarr.json: OME-Zarr 0.5 has a member of its own among the attributes.
  if (const auto attributes = root.find("attributes"))
    parseAttributes(*attributes, attributes->find("ome").value_or(*attributes), level, image);
  if (const auto names = root.find("dimension_names"); names && image.axes.empty())
    if (areAllNamed(*names)) image.axes = parseAxes(*names);
  return image;
}

std::vector<double> spaceScale(const ZarrImage& image) {
  // Without names, the last three axes are z, y and x; see rolesByNumber().
  if (image.axes.empty())
    return {image.scale.end() - std::min<std::ptrdiff_t>(3, std::ssize(image.scale)),
            image.scale.end()};
  std::vector<double> scale;
  for (size_t i = 0; i < std::min(image.scale.size(), image.axes.size()); ++i) {
    const std::optional<Role> role = roleOf(image.axes[i]);
    if (role != Role::kTime && role != Role::kChannel) scale.push_back(image.scale[i]);
  }
  return scale;
}

ZarrView viewZarr(const ZarrArray& array, const ZarrImage& image, bool channel_wanted,
                  const std::string& path) {
  const size_t axes = array.axes();
  if (axes < 3) fail("{}: expected an array of 3 to 5 axes, found {}", path, axes);
  if (!image.axes.empty() && image.axes.size() != axes)
    fail("{}: expected an array of {} axes, as named, found {}", path, image.axes.size(), axes);
  if (!image.scale.empty() && image.scale.size() != axes)
    fail("{}: expected a scale of {} numbers, as the array has axes, found {}", path, axes,
         image.scale.size());
  const std::vector<Role> roles =
      image.axes.empty() ? rolesByNumber(axes, channel_wanted) : rolesByName(image.axes, path);
  ZarrView view;
  for (const Role role :
       {Role::kX, Role::kY, Role::kZ, Role::kTime, Role::kChannel, Role::kSomeSpace}) {
    const auto count = std::count(roles.begin(), roles.end(), role);
    const bool is_space = role == Role::kX || role == Role::kY || role == Role::kZ;
    if (count > 1 || (count == 0 && is_space) || (count > 0 && role == Role::kSomeSpace))
      fail("{}: expected each of the axes x, y and z once, and time and channel at most once",
           path);
    if (count == 0) continue;
    const auto at =
        static_cast<size_t>(std::find(roles.begin(), roles.end(), role) - roles.begin());
    if (is_space) view.space[static_cast<size_t>(role)] = at;
    if (role == Role::kTime) view.time = at;
    if (role == Role::kChannel) view.channel = at;
  }
  for (size_t a = 0; a < 3; ++a) view.layout.dims[static_cast<int>(a)] = array.shape[view.space[a]];
  view.layout.type = array.type;
  view.layout.frame =
      image.frame.value_or(image.levels.empty() ? WorldFrame::kNone : WorldFrame::kPictureRows);
  view.layout.levels = std::max<int64_t>(1, static_cast<int64_t>(image.levels.size()));
  if (view.channel) view.layout.channels = array.shape[*view.channel];
  if (view.time) view.layout.time_steps = array.shape[*view.time];
  checkedVolumeBytes(path, view.layout);
  place(image, path, view);
  return view;
}

}  // namespace sluice
