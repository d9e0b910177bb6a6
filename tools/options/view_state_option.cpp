#include "tools/options/view_state_option.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>
#include <vector>

#include "src/base/error.h"
#include "src/options/option_rules.h"
#include "src/view/state/printed_command.h"
#include "src/view/state/view_check.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/usage.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 4> kOpacities{"--threshold", "--transfer", "--opacities",
                                                     "--labels"};
constexpr std::array<std::string_view, 2> kLight{"--shade", "--no-shade"};

bool isGiven(const CLI::App& app, const std::string& name) {
  if (name.empty()) return false;  // CLI11 would find any option
  const CLI::Option* option = app.get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

// The options of a word's kind, of which the user's take the place of all of the file's.
std::vector<std::string_view> optionsAlike(std::string_view name) {
  std::vector<std::string_view> camera;
  for (const OptionEntry& entry : optionTable())
    if (entry.part == OptionPart::kCamera && entry.option != "--fit")
      camera.push_back(entry.option);
  const std::vector<std::string_view> opacities(kOpacities.begin(), kOpacities.end());
  const std::vector<std::string_view> light(kLight.begin(), kLight.end());
  for (const auto& kind : {camera, opacities, light})
    if (std::find(kind.begin(), kind.end(), name) != kind.end()) return kind;
  return {name};
}

bool isGivenAny(const CLI::App& app, const std::vector<std::string_view>& names) {
  return std::any_of(names.begin(), names.end(),
                     [&](std::string_view name) { return isGiven(app, std::string(name)); });
}

// The options that the user gave. To be called before the file's options are added.
std::vector<const OptionEntry*> entriesGiven(const CLI::App& app) {
  std::vector<const OptionEntry*> given;
  for (const OptionEntry& entry : optionTable()) {
    std::vector<std::string_view> names = entry.kind.flags;
    names.insert(names.end(), {entry.option, entry.kind.needs});
    if (isGivenAny(app, names)) given.push_back(&entry);
  }
  return given;
}

// The view and its key frames without the properties that the user gave.
StateFile without(const std::vector<const OptionEntry*>& given, StateFile file) {
  const auto has = [&](std::string_view option) {
    return std::any_of(given.begin(), given.end(),
                       [&](const OptionEntry* entry) { return entry->option == option; });
  };
  const auto drop = [&](ViewState& state) {
    if (has("--crop")) state.crop.reset();
    if (has("--time")) state.time = 0;
    state.cross = {0, 0, 0};  // the window's alone
  };
  drop(file.state);
  if (file.path)
    for (ViewKey& key : file.path->keys) drop(key.state);
  return file;
}

// An option that makes labels of the values; empty: none does.
std::string_view labelsOption(const LookOptions& look) {
  if (look.labels) return "--labels";
  if (!look.label_table.empty()) return "--labels-table";
  return look.label_looks.empty() ? std::string_view() : "--label";
}

// Throws Error if the view with the user's options has a value without effect.
void requireNoConflict(ViewState state, const std::string& file, const std::string& place,
                       const std::vector<const OptionEntry*>& given, const ViewState& asked) {
  // Opacities that the user gave take the place of the file's labels.
  if (std::ranges::any_of(given, [](const OptionEntry* of) { return givesOpacities(*of); }))
    clearOption("--labels", state);
  // The user's values are judged together with the file's, as the picture will have both.
  for (const OptionEntry* entry : given)
    if (const auto value = entry->get(asked)) entry->set(state, *value);
  // The file is not to blame for what is wrong without it.
  if (const auto conflict = conflictIn(asked); conflict && conflict == conflictIn(state))
    failUsage("{}", *conflict);
  const auto nameOf = [&](std::string_view option) {
    const auto names = [&](const OptionEntry* entry) {
      return std::ranges::count(optionNames(*entry), option) > 0;
    };
    return std::ranges::any_of(given, names) ? std::string(option) : place + placeOf(option);
  };
  requireNoConflict(state, file, nameOf);
  // Options of one source exclude each other there.
  if (const std::string_view labels = labelsOption(state.look);
      !labels.empty() && !state.look.surfaces.empty())
    fail("{}: {} draws surfaces between values, which labels do not have; leave out {}", file,
         nameOf("--iso"), nameOf(labels));
}

// Parses what was added to an option. A wrong value is the file's fault, and no wrong usage.
void takeFromFile(CLI::Option& option, const std::string& file) {
  try {
    option.run_callback();
  } catch (const CLI::ParseError& error) {
    fail("{}: {}", file, error.what());
  }
}

}  // namespace

bool givesOpacities(const OptionEntry& entry) {
  return std::ranges::count(kOpacities, entry.option) > 0;
}

void SavedView::requireFits(const VolumeInfo& volume) const {
  sluice::requireFits(file.state, file.path, volume, name);
}

std::vector<std::string> SavedView::notes() const {
  if (!file.state.shows_slices) return {};
  return {fmt::format("{}: \"slices\" and \"cross\" are left out: slices show in the window alone",
                      name)};
}

bool SavedView::isToBlame(const Error& error) const {
  const std::string_view message = error.what();
  const auto isNamed = [&](const std::string& option) {
    const size_t at = message.find(option), end = at + option.size();
    if (at == std::string_view::npos) return false;
    return end == message.size() ||
           (message[end] != '-' && std::isalpha(static_cast<unsigned char>(message[end])) == 0);
  };
  return file.state.time != 0 || std::ranges::any_of(volume_options, isNamed);
}

SavedView applyState(CLI::App& app, const std::string& file, const ViewState& asked) {
  StateFile state = readState(file, interruption());
  const std::vector<const OptionEntry*> besides = entriesGiven(app);
  if (isGiven(app, "--fit") && state.state.view.look_at && !isGivenAny(app, optionsAlike("--eye")))
    failUsage("--fit: {} has an eye and a target, which say where the camera is; leave out --fit",
              file);
  requireNoConflict(state.state, file, "", besides, asked);
  for (size_t i = 0; state.path && i < state.path->keys.size(); ++i)
    requireNoConflict(state.path->keys[i].state, file, keyPlace(i), besides, asked);
  SavedView saved{without(besides, state), {}, file};
  if (state.path) saved.film = SavedFilm{*state.path, besides};
  // Options that count in the user's mode are taken from the file, and no others.
  if (isGiven(app, "--mode"))
    optionEntry("--mode").set(state.state, app.get_option("--mode")->as<std::string>());
  std::vector<OptionWord> words = pictureWords(state.state);
  const std::vector<OptionWord> look = lookWords(state.state.look);
  words.insert(words.end(), look.begin(), look.end());
  std::set<std::string> of_volume;
  CLI::Option* volume = app.get_option("volume");
  if (volume->count() == 0) {
    if (!state.volume) fail("{}: names no volume; give one", file);
    for (const std::string& path : state.volume->paths) volume->add_result(path);
    takeFromFile(*volume, file);
    const std::vector<OptionWord> more = volumeWords(state.volume->options);
    words.insert(words.end(), more.begin(), more.end());
    for (const OptionWord& word : more) of_volume.insert(word.first);
  }
  // --clip comes once for each of several planes.
  std::vector<std::string> given;
  for (const OptionWord& word : words)
    if (isGivenAny(app, optionsAlike(word.first))) given.push_back(word.first);
  for (const auto& [name, value] : words) {
    CLI::Option* option = app.get_option_no_throw(name);
    if (option == nullptr || std::find(given.begin(), given.end(), name) != given.end()) continue;
    // Each word is taken by itself: the one before may be of the same option (--clip).
    option->clear();
    option->add_result(value.empty() ? "true" : value);
    takeFromFile(*option, file);
    if (of_volume.contains(name)) saved.volume_options.push_back(name);
  }
  return saved;
}

}  // namespace sluice
