#include "src/view/state/files/state_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <system_error>

#include "src/base/error.h"
#include "src/base/field_names.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"
#include "src/view/state/files/file_name_json.h"
#include "src/view/state/view_check.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr uint64_t kMostBytes = uint64_t{1} << 20;
constexpr double kMostRate = 1000, kMostSeconds = 1e6;

std::string absolutePath(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown) || unknown) return path;
  const auto absolute = std::filesystem::absolute(path, unknown);
  return unknown ? path : absolute.string();
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

json jsonOf(OptionForm form, const OptionValue& value) {
  const auto* const text = std::get_if<std::string>(&value);
  // The view may be loaded from another working directory.
  if (form == OptionForm::kFile) return fileNameJson(absolutePath(*text));
  if (form == OptionForm::kName || (form == OptionForm::kChannel && text != nullptr))
    return fileNameJson(*text);
  if (form == OptionForm::kDims) {
    const auto& n = std::get<OptionWholes>(value);  // the time steps have a key of their own
    return {n[0], n[1], n[2]};
  }
  if (form == OptionForm::kChannels) {
    json made = json::array();
    for (const std::string& look : std::get<std::vector<std::string>>(value))
      made.push_back(channelJson(look));
    return made;
  }
  return std::visit([](const auto& held) { return json(held); }, value);
}

json volumeJson(const ViewedVolume& volume) {
  json made;
  for (const std::string& path : volume.paths)
    made["paths"].push_back(fileNameJson(absolutePath(path)));
  for (const VolumeEntry& entry : volumeTable())
    if (const auto value = savedValue(entry, volume.options))
      made[entry.key] = jsonOf(entry.kind.form, *value);
  return made;
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

// Empty, it would be as if the field were not there.
std::string nameOf(const JsonField& field) {
  std::string name = fileNameOf(field);
  if (name.empty()) field.failExpected("a name that is not empty");
  return name;
}

// A list of texts, each `expected`.
std::vector<std::string> textsOf(const JsonField& field, const std::string& expected,
                                 bool (*is_right)(const std::string&)) {
  if (!field.isArray()) field.failExpected("a list, each " + expected);
  std::vector<std::string> texts;
  for (size_t i = 0; i < field.size(); ++i) {
    const JsonField item = field[i];
    // Names of channels and of their tables may be bytes.
    if (!item.isText() && !(item.isObject() && item.find("bytes"))) item.failExpected(expected);
    texts.push_back(fileNameOf(item));
    if (!is_right(texts.back())) field[i].failExpected(expected);
  }
  return texts;
}

OptionValue valueOf(const OptionKind& kind, const JsonField& field) {
  const OptionForm form = kind.form;
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
      return std::string(kind.words[wordOf(field, kind.words)]);
    case OptionForm::kText:
      return field.text();
    case OptionForm::kChannel:
      // A channel is a number or a name.
      if (field.isNumber()) return field.whole();
      [[fallthrough]];
    case OptionForm::kFile:
    case OptionForm::kName:
      return nameOf(field);
    case OptionForm::kVoxel:
    case OptionForm::kDims:
    case OptionForm::kBox:
      return listOf<int64_t>(field, count);
    case OptionForm::kColor:
      for (size_t i = 0; i < field.size(); ++i) field[i].share();  // before they become floats
      [[fallthrough]];
    case OptionForm::kRange:
    case OptionForm::kAngles:
    case OptionForm::kPlace:
    case OptionForm::kDirection:
    case OptionForm::kSpacing:
      return listOf<double>(field, count);
    case OptionForm::kChannels:
      return textsOf(field, R"(the look of a channel as a text, such as "0:green,400:3000,0.1")",
                     [](const std::string& text) { return parseChannelLook(text).has_value(); });
    case OptionForm::kLabels:
      return textsOf(field, R"(the look of labels as a text, such as "3=ff8800:0.4")",
                     [](const std::string& text) { return parseLabelLook(text).has_value(); });
    case OptionForm::kSurfaces:
      return textsOf(field, R"(a surface as a text, such as "300:0.4:ff8800")",
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

[[noreturn]] void failFault(const std::string& where, const std::string& place,
                            const ViewFault& fault) {
  fail("{}: expected {} at {}{}, found {}", where, fault.expected, place, fault.field, fault.found);
}

ViewedVolume volumeOf(const JsonField& field, const std::string& where) {
  std::vector<std::string_view> keys{"paths"};
  for (const VolumeEntry& entry : volumeTable()) keys.emplace_back(entry.key);
  field.allowOnly(keys);
  ViewedVolume volume;
  const JsonField paths = field.require("paths");
  if (!paths.isArray() || paths.size() == 0) paths.failExpected("a list of files");
  for (size_t i = 0; i < paths.size(); ++i) volume.paths.push_back(nameOf(paths[i]));
  for (const VolumeEntry& entry : volumeTable())
    if (const auto f = field.find(entry.key)) {
      const OptionValue value = valueOf(entry.kind, *f);
      if (const auto fault = faultOf(entry.kind, value, std::string("/") + entry.key))
        failFault(where, "/volume", *fault);
      entry.set(volume.options, value);
    }
  if (volume.options.time_steps && !volume.options.dims)
    field.require("time_steps").failExpected("\"dims\", too, because both are of a raw volume,");
  return volume;
}

constexpr std::array kParts{"camera", "look"};

// Adds the names of a part's options.
void addKeys(std::vector<std::string_view>& keys, OptionPart part) {
  for (const OptionEntry& entry : optionTable())
    if (entry.part == part) keys.emplace_back(entry.key);
}

// The state without its volume and its path.
json stateJson(const ViewState& whole) {
  json made;
  const ViewState state = withoutConflicts(whole);
  for (const OptionEntry& entry : optionTable()) {
    const std::optional<OptionValue> value = savedValue(entry, state);
    if (!value) continue;
    json& part =
        entry.part == OptionPart::kTop ? made : made[kParts[static_cast<size_t>(entry.part)]];
    part[entry.key] = jsonOf(entry.kind.form, *value);
  }
  return made;
}

void readPart(const JsonField& field, OptionPart part, ViewState& state) {
  for (const OptionEntry& entry : optionTable())
    if (entry.part == part)
      if (const auto f = field.find(entry.key)) entry.set(state, valueOf(entry.kind, *f));
}

// Throws Error if a part has two keys of which a picture takes one, as the options of the same
// names exclude each other. A view is never saved with both. `state`: with the part's values.
void requireOneOfEach(const JsonField& field, OptionPart part, const ViewState& state) {
  const auto find = [&](std::string_view option) -> const OptionEntry* {
    for (const OptionEntry& entry : optionTable())
      if (entry.part == part && entry.option == option && field.find(entry.key)) return &entry;
    return nullptr;
  };
  for (const auto& pair : optionsApart()) {
    const OptionEntry* const one = find(pair.one);
    const OptionEntry* const other = find(pair.other);
    if (one == nullptr || other == nullptr) continue;
    const JsonField found = *field.find(other->key);
    if (pair.one == "--eye")
      found.failExpected(R"(no value beside "eye" and "target", which replace it,)");
    // An empty list and false ask for nothing.
    const auto asks = [&](const OptionEntry& entry) {
      return entry.get(state).value_or(false) != OptionValue(false);
    };
    if (asks(*one) && asks(*other))
      found.failExpected(
          fmt::format("no value beside \"{}\", of which one is to be left out,", one->key));
  }
}

// `place`: of the object in the document, as a JSON pointer.
ViewState stateOf(const JsonField& root, const std::string& where, const std::string& place) {
  // Fields that a file leaves out have their defaults, not the values of the view that is shown.
  ViewState state;
  for (const OptionPart part : {OptionPart::kCamera, OptionPart::kLook}) {
    const auto field = root.find(kParts[static_cast<size_t>(part)]);
    if (!field) continue;
    std::vector<std::string_view> keys;
    addKeys(keys, part);
    field->allowOnly(keys);
    readPart(*field, part, state);
    requireOneOfEach(*field, part, state);
    // An eye alone gives no direction, and a target alone no distance.
    if (part == OptionPart::kCamera &&
        field->find("eye").has_value() != field->find("target").has_value())
      field->failExpected("eye and target together");
  }
  readPart(root, OptionPart::kTop, state);
  if (const std::optional<ViewFault> fault = faultOf(state)) failFault(where, place, *fault);
  requireNoConflict(state, where, [&](std::string_view option) { return place + placeOf(option); });
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
      // The cross hair and the panes belong to the window, not to a key.
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
  if (const auto f = root.find("volume")) file.volume = volumeOf(*f, where);
  file.state = stateOf(root, where, {});
  if (const auto f = root.find("path")) file.path = pathOf(*f, where);
  return file;
}

std::string placeOf(std::string_view option) {
  for (const OptionEntry& entry : optionTable()) {
    const bool is_in_part = entry.part == OptionPart::kCamera || entry.part == OptionPart::kLook;
    std::string place = "/";
    if (is_in_part) place += std::string(kParts[static_cast<size_t>(entry.part)]) + "/";
    place += entry.key;
    const auto& flags = entry.kind.flags;
    const auto flag = std::ranges::find(flags, option);
    if (flag != flags.end())
      return fmt::format("{} {}", place,
                         entry.kind.words[static_cast<size_t>(flag - flags.begin())]);
    if (entry.option == option) return place;
  }
  return std::string(option);
}

void requireNoConflict(const ViewState& state, const std::string& where,
                       const std::function<std::string(std::string_view option)>& nameOf) {
  if (const auto conflict = conflictIn(state)) fail("{}: {}", where, renamed(*conflict, nameOf));
}

StateFile readState(const std::filesystem::path& path, const StopToken& stop) {
  return parseState(readTextFile(path, kMostBytes, "a view's state in JSON", stop), path.string());
}

}  // namespace sluice
