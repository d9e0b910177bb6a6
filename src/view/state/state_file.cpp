#include "src/view/state/state_file.h"

#include <array>
#include <nlohmann/json.hpp>
#include <system_error>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/view/state/file_name_json.h"
#include "src/view/state/view_check.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr uint64_t kMostBytes = uint64_t{1} << 20;
constexpr double kMostSpacing = 1e15, kMostRate = 1000, kMostSeconds = 1e6;
constexpr std::array kModes{"composite", "mip", "minip", "average"};
constexpr std::array kTypes{"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"};
constexpr std::array kLights{"chosen", "on", "off"};
constexpr std::array kViews{"plain", "front", "back",   "left",
                            "right", "top",   "bottom", "three-quarter"};

std::string absolutePath(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown) || unknown) return path;
  const auto absolute = std::filesystem::absolute(path, unknown);
  return unknown ? path : absolute.string();
}

json volumeJson(const ViewedVolume& volume) {
  json made;
  for (const std::string& path : volume.paths)
    made["paths"].push_back(fileNameJson(absolutePath(path)));
  const VolumeOptions& options = volume.options;
  if (options.dims) made["dims"] = *options.dims;
  if (!options.type.empty()) made["type"] = options.type;
  if (options.big_endian) made["big_endian"] = true;
  if (options.skip_bytes != 0) made["skip"] = options.skip_bytes;
  if (options.time_steps) made["time_steps"] = *options.time_steps;
  if (options.spacing) made["spacing"] = *options.spacing;
  if (!options.grid.empty()) made["grid"] = options.grid;
  if (options.channel)
    made["channel"] = *options.channel;
  else if (!options.channel_name.empty())
    made["channel"] = options.channel_name;
  return made;
}

json cameraJson(const ViewOptions& view) {
  json made;
  const bool is_perspective = view.projection == ViewOptions::Projection::kPerspective;
  made["projection"] = is_perspective ? "perspective" : "ortho";
  made["zoom"] = view.zoom;
  made["fov"] = view.field_of_view_deg;
  if (view.up) made["up"] = *view.up;
  if (view.look_at) {
    made["eye"] = view.look_at->eye;
    made["target"] = view.look_at->target;
  } else {
    made["view"] = kViews[static_cast<size_t>(view.from)];
    made["azimuth"] = view.azimuth_deg;
    made["elevation"] = view.elevation_deg;
    if (view.fit) made["fit"] = *view.fit == ViewOptions::Fit::kVolume ? "volume" : "visible";
  }
  return made;
}

json lookJson(const LookOptions& look) {
  json made;
  made["mode"] = kModes[static_cast<size_t>(look.mode)];
  made["light"] = kLights[static_cast<size_t>(look.light)];
  if (look.threshold) made["threshold"] = *look.threshold;
  if (look.opacity) made["opacity"] = *look.opacity;
  for (const LookOptions::Opacity& point : look.opacities)
    made["opacities"].push_back({point.value, point.opacity});
  if (!look.transfer_file.empty())
    made["transfer"] = fileNameJson(absolutePath(look.transfer_file));
  if (look.labels) made["labels"] = true;
  if (!look.map.empty()) made["map"] = look.map;
  if (look.range) made["range"] = *look.range;
  if (look.full_gradient) made["full_gradient"] = *look.full_gradient;
  return made;
}

// `count` numbers.
template <class Number, size_t count>
std::array<Number, count> numbers(const JsonField& field) {
  if (!field.isArray() || field.size() != count)
    field.failExpected(fmt::format("{} numbers", count));
  std::array<Number, count> found{};
  for (size_t i = 0; i < count; ++i) {
    if constexpr (std::is_integral_v<Number>)
      found[i] = field[i].whole();
    else
      found[i] = static_cast<Number>(field[i].number());
  }
  return found;
}

// The position of a word among those that are known.
template <size_t count>
size_t wordOf(const JsonField& field, const std::array<const char*, count>& words) {
  const std::string& word = field.text();
  std::string all;
  for (size_t i = 0; i < count; ++i) {
    if (word == words[i]) return i;
    all += (i == 0 ? "" : ", ") + std::string(words[i]);
  }
  field.failExpected("one of " + all);
}

// A number in (0, most].
double aboveZero(const JsonField& field, double most) {
  const double number = field.number();
  if (!(number > 0 && number <= most))
    field.failExpected(fmt::format("a number above 0, up to {}", most));
  return number;
}

int64_t wholeFrom(int64_t least, const JsonField& field) {
  const int64_t number = field.whole();
  if (number < least) field.failExpected(fmt::format("a whole number from {}", least));
  return number;
}

ViewedVolume volumeOf(const JsonField& field) {
  field.allowOnly(
      {"paths", "dims", "type", "big_endian", "skip", "time_steps", "spacing", "grid", "channel"});
  ViewedVolume volume;
  const JsonField paths = field.require("paths");
  if (!paths.isArray() || paths.size() == 0) paths.failExpected("a list of files");
  for (size_t i = 0; i < paths.size(); ++i) volume.paths.push_back(fileNameOf(paths[i]));
  VolumeOptions& options = volume.options;
  if (const auto f = field.find("dims")) {
    options.dims = numbers<int64_t, 3>(*f);
    for (size_t a = 0; a < 3; ++a) wholeFrom(1, (*f)[a]);
  }
  if (const auto f = field.find("type")) options.type = kTypes[wordOf(*f, kTypes)];
  if (const auto f = field.find("big_endian")) options.big_endian = f->flag();
  if (const auto f = field.find("skip")) options.skip_bytes = wholeFrom(0, *f);
  if (const auto f = field.find("time_steps")) options.time_steps = wholeFrom(1, *f);
  if (const auto f = field.find("spacing")) {
    options.spacing = numbers<double, 3>(*f);
    for (size_t a = 0; a < 3; ++a) aboveZero((*f)[a], kMostSpacing);
  }
  if (const auto f = field.find("grid")) options.grid = f->text();
  if (const auto f = field.find("channel")) {
    if (f->isText())
      options.channel_name = f->text();
    else
      options.channel = wholeFrom(0, *f);
  }
  return volume;
}

ViewOptions viewOf(const JsonField& field) {
  field.allowOnly(
      {"projection", "zoom", "fov", "up", "eye", "target", "view", "azimuth", "elevation", "fit"});
  ViewOptions view;
  constexpr std::array kProjections{"ortho", "perspective"};
  constexpr std::array kFits{"visible", "volume"};
  if (const auto f = field.find("projection"))
    view.projection = static_cast<ViewOptions::Projection>(wordOf(*f, kProjections));
  if (const auto f = field.find("zoom")) view.zoom = f->number();
  if (const auto f = field.find("fov")) view.field_of_view_deg = f->number();
  if (const auto f = field.find("up")) view.up = numbers<double, 3>(*f);
  const auto eye = field.find("eye"), target = field.find("target");
  if (eye.has_value() != target.has_value()) field.failExpected("eye and target together");
  if (eye)
    view.look_at = ViewOptions::LookAt{numbers<double, 3>(*eye), numbers<double, 3>(*target)};
  if (const auto f = field.find("view"))
    view.from = static_cast<ViewOptions::From>(wordOf(*f, kViews));
  if (const auto f = field.find("azimuth")) view.azimuth_deg = f->number();
  if (const auto f = field.find("elevation")) view.elevation_deg = f->number();
  if (const auto f = field.find("fit")) view.fit = static_cast<ViewOptions::Fit>(wordOf(*f, kFits));
  return view;
}

LookOptions lookOf(const JsonField& field) {
  field.allowOnly({"mode", "light", "threshold", "opacity", "opacities", "transfer", "labels",
                   "map", "range", "full_gradient"});
  LookOptions look;
  if (const auto f = field.find("mode"))
    look.mode = static_cast<LookOptions::Mode>(wordOf(*f, kModes));
  if (const auto f = field.find("light"))
    look.light = static_cast<LookOptions::Light>(wordOf(*f, kLights));
  if (const auto f = field.find("threshold")) look.threshold = f->number();
  if (const auto f = field.find("opacity")) look.opacity = f->number();
  if (const auto f = field.find("opacities")) {
    if (!f->isArray()) f->failExpected("a list of pairs of a value and an opacity");
    for (size_t i = 0; i < f->size(); ++i) {
      const auto pair = numbers<double, 2>((*f)[i]);
      look.opacities.push_back({pair[0], pair[1]});
    }
  }
  if (const auto f = field.find("transfer")) look.transfer_file = fileNameOf(*f);
  if (const auto f = field.find("labels")) look.labels = f->flag();
  if (const auto f = field.find("map")) look.map = f->text();
  if (const auto f = field.find("range")) look.range = numbers<double, 2>(*f);
  if (const auto f = field.find("full_gradient")) look.full_gradient = f->number();
  return look;
}

// The state without its volume and its path.
json stateJson(const ViewState& state) {
  json made;
  made["camera"] = cameraJson(state.view);
  made["look"] = lookJson(state.look);
  made["time"] = state.time;
  if (state.step_vox) made["step"] = *state.step_vox;
  if (state.crop)
    made["crop"] = {state.crop->lo[0], state.crop->lo[1], state.crop->lo[2],
                    state.crop->hi[0], state.crop->hi[1], state.crop->hi[2]};
  for (const PictureOptions::Plane& plane : state.clip_planes)
    made["clip"].push_back({plane.normal[0], plane.normal[1], plane.normal[2], plane.offset});
  if (state.background) made["background"] = *state.background;
  made["cross"] = state.cross;
  made["slices"] = state.shows_slices;
  return made;
}

// `place`: of the object in the document, as a JSON pointer.
ViewState stateOf(const JsonField& root, const std::string& where, const std::string& place) {
  ViewState state;
  if (const auto f = root.find("camera")) state.view = viewOf(*f);
  if (const auto f = root.find("look")) state.look = lookOf(*f);
  if (const auto f = root.find("time")) state.time = f->whole();
  if (const auto f = root.find("step")) state.step_vox = f->number();
  if (const auto f = root.find("crop")) {
    const auto n = numbers<int64_t, 6>(*f);
    state.crop = PictureOptions::Box{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  }
  if (const auto f = root.find("clip")) {
    if (!f->isArray()) f->failExpected("a list of planes, four numbers each");
    for (size_t i = 0; i < f->size(); ++i) {
      const auto n = numbers<double, 4>((*f)[i]);
      state.clip_planes.push_back({{n[0], n[1], n[2]}, n[3]});
    }
  }
  if (const auto f = root.find("background")) {
    for (size_t i = 0; i < f->size(); ++i) (*f)[i].share();  // before it becomes a float
    state.background = numbers<float, 3>(*f);
  }
  if (const auto f = root.find("cross")) state.cross = numbers<int64_t, 3>(*f);
  if (const auto f = root.find("slices")) state.shows_slices = f->flag();
  if (const std::optional<ViewFault> fault = faultOf(state))
    fail("{}: expected {} at {}{}, found {}", where, fault->expected, place, fault->field,
         fault->found);
  return state;
}

constexpr std::array kPathKinds{"turn", "keys"};

json pathJson(const ViewPath& path) {
  json made = {{"kind", kPathKinds[static_cast<size_t>(path.kind)]},
               {"frames", path.turn_frames},
               {"rate", path.frames_per_second}};
  for (const ViewKey& key : path.keys) {
    json one = stateJson(key.state);
    one.erase("cross");
    one.erase("slices");
    one["seconds"] = key.seconds;
    made["keys"].push_back(std::move(one));
  }
  return made;
}

ViewPath pathOf(const JsonField& field, const std::string& where) {
  field.allowOnly({"kind", "frames", "rate", "keys"});
  ViewPath path;
  path.kind = static_cast<ViewPath::Kind>(wordOf(field.require("kind"), kPathKinds));
  if (const auto f = field.find("frames")) {
    path.turn_frames = f->whole();
    if (path.turn_frames < 1 || path.turn_frames > ViewPath::kMostFrames)
      f->failExpected(fmt::format("1 to {} frames", ViewPath::kMostFrames));
  }
  if (const auto f = field.find("rate")) path.frames_per_second = aboveZero(*f, kMostRate);
  const auto keys = field.find("keys");
  if (keys && !keys->isArray()) keys->failExpected("a list of views");
  for (size_t i = 0; keys && i < keys->size(); ++i) {
    const JsonField one = (*keys)[i];
    one.allowOnly({"seconds", "camera", "look", "time", "step", "crop", "clip", "background"});
    ViewKey key;
    if (const auto f = one.find("seconds")) key.seconds = aboveZero(*f, kMostSeconds);
    key.state = stateOf(one, where, keyPlace(i));
    if (!key.state.view.look_at) one.failExpected("a camera with eye and target");
    path.keys.push_back(std::move(key));
  }
  if (path.kind == ViewPath::Kind::kKeys && path.keys.empty())
    field.failExpected("at least one of \"keys\"");
  if (secondsOf(path) > kMostSeconds) field.failExpected(fmt::format("at most {} s", kMostSeconds));
  if (path.kind == ViewPath::Kind::kKeys &&
      secondsOf(path) * path.frames_per_second >= static_cast<double>(ViewPath::kMostFrames))
    field.failExpected(fmt::format("at most {} frames", ViewPath::kMostFrames));
  return path;
}

}  // namespace

std::string stateText(const ViewedVolume& volume, const ViewState& state,
                      const std::optional<ViewPath>& path) {
  json made = stateJson(state);
  made["sluice"] = "view";
  if (!volume.paths.empty()) made["volume"] = volumeJson(volume);
  if (path) made["path"] = pathJson(*path);
  // Only texts that no file is opened by, such as a map's name, may still be no UTF-8.
  return made.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

StateFile parseState(std::string_view text, const std::string& where) {
  const json document = parseJson(text, where);
  const JsonField root(document, where);
  if (!root.isObject() || !root.find("sluice") || !root.find("sluice")->isText() ||
      root.find("sluice")->text() != "view")
    fail("{}: expected a view's state, an object with \"sluice\": \"view\"", where);
  root.allowOnly({"sluice", "volume", "camera", "look", "time", "step", "crop", "clip",
                  "background", "cross", "slices", "path"});
  StateFile file;
  if (const auto f = root.find("volume")) file.volume = volumeOf(*f);
  file.state = stateOf(root, where, {});
  if (const auto f = root.find("path")) file.path = pathOf(*f, where);
  return file;
}

void writeState(const std::filesystem::path& path, const ViewedVolume& volume,
                const ViewState& state) {
  AtomicFile file(path);
  file.write(stateText(volume, state));
  file.commit();
}

StateFile readState(const std::filesystem::path& path, const StopToken& stop) {
  return parseState(readTextFile(path, kMostBytes, "a view's state in JSON", stop), path.string());
}

}  // namespace sluice
