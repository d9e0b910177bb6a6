#include "src/view/state/state_file.h"

#include <array>
#include <nlohmann/json.hpp>
#include <system_error>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/options/option_table.h"
#include "src/view/state/file_name_json.h"
#include "src/view/state/view_check.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr uint64_t kMostBytes = uint64_t{1} << 20;
constexpr double kMostSpacing = 1e15, kMostRate = 1000, kMostSeconds = 1e6;
constexpr std::array kTypes{"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"};

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
  if (!options.grid.empty()) made["grid"] = fileNameJson(options.grid);
  if (options.channel)
    made["channel"] = *options.channel;
  else if (!options.channel_name.empty())
    made["channel"] = fileNameJson(options.channel_name);
  if (!options.over.empty()) made["over"] = fileNameJson(absolutePath(options.over));
  return made;
}

// The look of a channel, whose table of labels becomes absolute as other files do, unless the
// option could not name it then: a comma or a colon ends the name there.
json channelJson(const std::string& text) {
  std::optional<ChannelLook> look = parseChannelLook(text);
  if (!look || !isLabelTable(look->map)) return fileNameJson(text);
  look->map = absolutePath(look->map);
  const std::string moved = channelLookText(*look);
  return fileNameJson(parseChannelLook(moved) == look ? moved : text);
}

json jsonOf(const OptionEntry& entry, const OptionValue& value) {
  if (entry.kind.form == OptionForm::kFile)
    return fileNameJson(absolutePath(std::get<std::string>(value)));
  if (entry.kind.form == OptionForm::kChannels) {
    json made = json::array();
    for (const std::string& text : std::get<std::vector<std::string>>(value))
      made.push_back(channelJson(text));
    return made;
  }
  return std::visit([](const auto& held) { return json(held); }, value);
}

template <class Number>
std::vector<Number> listOf(const JsonField& field, size_t count) {
  if (!field.isArray() || field.size() != count)
    field.failExpected(fmt::format("{} numbers", count));
  std::vector<Number> found;
  for (size_t i = 0; i < count; ++i) {
    if constexpr (std::is_integral_v<Number>)
      found.push_back(field[i].whole());
    else
      found.push_back(field[i].number());
  }
  return found;
}

template <class Number>
std::array<Number, 3> tripleOf(const JsonField& field) {
  const std::vector<Number> n = listOf<Number>(field, 3);
  return {n[0], n[1], n[2]};
}

// The position of a word among those that are known.
template <class Words>
size_t wordOf(const JsonField& field, const Words& words) {
  const std::string& word = field.text();
  std::string all;
  for (size_t i = 0; i < words.size(); ++i) {
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

// Empty, it would be as if the field were not there.
std::string nameOf(const JsonField& field) {
  std::string name = fileNameOf(field);
  if (name.empty()) field.failExpected("a name that is not empty");
  return name;
}

ViewedVolume volumeOf(const JsonField& field) {
  field.allowOnly({"paths", "dims", "type", "big_endian", "skip", "time_steps", "spacing", "grid",
                   "channel", "over"});
  ViewedVolume volume;
  const JsonField paths = field.require("paths");
  if (!paths.isArray() || paths.size() == 0) paths.failExpected("a list of files");
  for (size_t i = 0; i < paths.size(); ++i) volume.paths.push_back(nameOf(paths[i]));
  VolumeOptions& options = volume.options;
  if (const auto f = field.find("dims")) {
    options.dims = tripleOf<int64_t>(*f);
    for (size_t a = 0; a < 3; ++a) wholeFrom(1, (*f)[a]);
  }
  if (const auto f = field.find("type")) options.type = kTypes[wordOf(*f, kTypes)];
  if (const auto f = field.find("big_endian")) options.big_endian = f->flag();
  if (const auto f = field.find("skip")) options.skip_bytes = wholeFrom(0, *f);
  if (const auto f = field.find("time_steps")) {
    options.time_steps = wholeFrom(1, *f);
    if (!options.dims) f->failExpected("\"dims\", too, because both are of a raw volume,");
  }
  if (const auto f = field.find("spacing")) {
    options.spacing = tripleOf<double>(*f);
    for (size_t a = 0; a < 3; ++a) aboveZero((*f)[a], kMostSpacing);
  }
  if (const auto f = field.find("grid")) options.grid = nameOf(*f);
  if (const auto f = field.find("channel")) {
    if (f->isNumber())
      options.channel = wholeFrom(0, *f);
    else
      options.channel_name = nameOf(*f);
  }
  if (const auto f = field.find("over")) options.over = nameOf(*f);
  return volume;
}

// A list of texts, each `expected`.
std::vector<std::string> textsOf(const JsonField& field, const std::string& expected,
                                 bool (*is_right)(const std::string&)) {
  if (!field.isArray()) field.failExpected("a list, each " + expected);
  std::vector<std::string> texts;
  for (size_t i = 0; i < field.size(); ++i) {
    texts.push_back(fileNameOf(field[i]));
    if (!is_right(texts.back())) field[i].failExpected(expected);
  }
  return texts;
}

OptionValue valueOf(const OptionEntry& entry, const JsonField& field) {
  const OptionForm form = entry.kind.form;
  const size_t count = numbersOf(form);
  switch (form) {
    case OptionForm::kFlag:
      return field.flag();
    case OptionForm::kWhole:
    case OptionForm::kBytes:
      return field.whole();
    case OptionForm::kNumber:
    case OptionForm::kSeconds:
      return field.number();
    case OptionForm::kWord:
      return std::string(entry.kind.words[wordOf(field, entry.kind.words)]);
    case OptionForm::kText:
      return field.text();
    case OptionForm::kFile:
      return nameOf(field);
    case OptionForm::kVoxel:
    case OptionForm::kBox:
      return listOf<int64_t>(field, count);
    case OptionForm::kColor:
      for (size_t i = 0; i < field.size(); ++i) field[i].share();  // before they become floats
      [[fallthrough]];
    case OptionForm::kRange:
    case OptionForm::kAngles:
    case OptionForm::kPlace:
    case OptionForm::kDirection:
      return listOf<double>(field, count);
    case OptionForm::kChannels:
      return textsOf(field, "a look of a channel, such as 0:green,400:3000,0.1",
                     [](const std::string& text) { return parseChannelLook(text).has_value(); });
    case OptionForm::kLabels:
      return textsOf(field, "a look of labels, such as 3=ff8800:0.4",
                     [](const std::string& text) { return parseLabelLook(text).has_value(); });
    case OptionForm::kSurfaces:
      return textsOf(field, "a surface, such as 300:0.4:ff8800",
                     [](const std::string& text) { return parseSurfaceLook(text).has_value(); });
    case OptionForm::kPoints:
    case OptionForm::kPlanes:
      break;
  }
  if (!field.isArray())
    field.failExpected(form == OptionForm::kPoints ? "a list of pairs of a value and an opacity"
                                                   : "a list of planes, four numbers each");
  std::vector<OptionReals> lists;
  for (size_t i = 0; i < field.size(); ++i) lists.push_back(listOf<double>(field[i], count));
  return lists;
}

constexpr std::array kParts{"camera", "look"};

// Adds the names of a part's options.
void addKeys(std::vector<std::string_view>& keys, OptionPart part) {
  for (const OptionEntry& entry : optionTable())
    if (entry.part == part) keys.emplace_back(entry.key);
}

// The state without its volume and its path.
json stateJson(const ViewState& state) {
  json made;
  for (const OptionEntry& entry : optionTable()) {
    const std::optional<OptionValue> value = savedValue(entry, state);
    if (!value) continue;
    json& part =
        entry.part == OptionPart::kTop ? made : made[kParts[static_cast<size_t>(entry.part)]];
    part[entry.key] = jsonOf(entry, *value);
  }
  return made;
}

void readPart(const JsonField& field, OptionPart part, ViewState& state) {
  for (const OptionEntry& entry : optionTable())
    if (entry.part == part)
      if (const auto f = field.find(entry.key)) entry.set(state, valueOf(entry, *f));
}

// `place`: of the object in the document, as a JSON pointer.
ViewState stateOf(const JsonField& root, const std::string& where, const std::string& place) {
  ViewState state;
  for (const OptionPart part : {OptionPart::kCamera, OptionPart::kLook}) {
    const auto field = root.find(kParts[static_cast<size_t>(part)]);
    if (!field) continue;
    std::vector<std::string_view> keys;
    addKeys(keys, part);
    field->allowOnly(keys);
    readPart(*field, part, state);
    if (part == OptionPart::kCamera &&
        field->find("eye").has_value() != field->find("target").has_value())
      field->failExpected("eye and target together");
  }
  readPart(root, OptionPart::kTop, state);
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
    for (const OptionEntry& entry : optionTable())
      if (entry.option.empty()) one.erase(entry.key);
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
  std::vector<std::string_view> keys_of_frame{"seconds", kParts[0], kParts[1]};
  for (const OptionEntry& entry : optionTable())
    if (entry.part == OptionPart::kTop && !entry.option.empty())
      keys_of_frame.emplace_back(entry.key);
  const auto keys = field.find("keys");
  if (keys && !keys->isArray()) keys->failExpected("a list of views");
  for (size_t i = 0; keys && i < keys->size(); ++i) {
    const JsonField one = (*keys)[i];
    one.allowOnly(keys_of_frame);
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
  std::vector<std::string_view> known{"sluice", "volume", kParts[0], kParts[1]};
  addKeys(known, OptionPart::kTop);
  known.emplace_back("path");
  root.allowOnly(known);
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
