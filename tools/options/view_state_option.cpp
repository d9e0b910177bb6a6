#include "tools/options/view_state_option.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "src/base/error.h"
#include "src/view/state/printed_command.h"
#include "src/view/state/view_check.h"
#include "tools/command_line/interrupt.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 9> kCamera{"--view", "--azimuth", "--elevation",
                                                  "--eye",  "--target",  "--up",
                                                  "--zoom", "--fov",     "--projection"};
constexpr std::array<std::string_view, 4> kOpacities{"--threshold", "--transfer", "--opacities",
                                                     "--labels"};
constexpr std::array<std::string_view, 2> kLight{"--shade", "--no-shade"};

bool isGiven(const CLI::App& app, const std::string& name) {
  const CLI::Option* option = app.get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

// Options of which the user gave one: the file's are left out.
template <class List>
bool isGivenAny(const CLI::App& app, const List& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) return false;
  return std::any_of(names.begin(), names.end(),
                     [&](std::string_view other) { return isGiven(app, std::string(other)); });
}

// The kinds of options that the user gave. To be called before the file's options are added.
SavedFilm givenBesides(const CLI::App& app) {
  const auto hasAny = [&](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(),
                       [&](const char* name) { return isGiven(app, name); });
  };
  SavedFilm given;
  given.has_camera = isGivenAny(app, kCamera, "--view");
  given.has_look = isGivenAny(app, kOpacities, "--threshold") ||
                   isGivenAny(app, kLight, "--shade") ||
                   hasAny({"--map", "--range", "--opacity", "--modulate", "--mode"});
  given.has_step = hasAny({"--step"});
  given.has_crop = hasAny({"--crop"});
  given.has_clip = hasAny({"--clip"});
  given.has_time = hasAny({"--time"});
  given.has_background = hasAny({"--background"});
  return given;
}

// The view and its key frames without the properties that the user gave.
StateFile without(const SavedFilm& given, StateFile file) {
  const auto drop = [&](ViewState& state) {
    if (given.has_crop) state.crop.reset();
    if (given.has_time) state.time = 0;
    state.cross = {0, 0, 0};  // the window's alone
  };
  drop(file.state);
  if (file.path)
    for (ViewKey& key : file.path->keys) drop(key.state);
  return file;
}

}  // namespace

void SavedView::requireFits(const VolumeInfo& volume) const {
  sluice::requireFits(file.state, file.path, volume, name);
}

SavedView applyState(CLI::App& app, const std::string& file) {
  const StateFile state = readState(file, interruption());
  const SavedFilm besides = givenBesides(app);
  SavedView saved{without(besides, state), {}, file};
  if (state.path) {
    saved.film = besides;
    saved.film->path = *state.path;
  }
  std::vector<OptionWord> words = pictureWords(state.state);
  const std::vector<OptionWord> look = lookWords(state.state.look);
  words.insert(words.end(), look.begin(), look.end());
  CLI::Option* volume = app.get_option("volume");
  if (volume->count() == 0) {
    if (!state.volume) fail("{}: names no volume; give one", file);
    for (const std::string& path : state.volume->paths) volume->add_result(path);
    volume->run_callback();
    const std::vector<OptionWord> more = volumeWords(state.volume->options);
    words.insert(words.end(), more.begin(), more.end());
  }
  // --clip comes once for each of several planes.
  std::vector<std::string> given;
  for (const OptionWord& word : words)
    if (isGiven(app, word.first) || isGivenAny(app, kCamera, word.first) ||
        isGivenAny(app, kOpacities, word.first) || isGivenAny(app, kLight, word.first))
      given.push_back(word.first);
  for (const auto& [name, value] : words) {
    CLI::Option* option = app.get_option_no_throw(name);
    if (option == nullptr || std::find(given.begin(), given.end(), name) != given.end()) continue;
    option->clear();
    option->add_result(value.empty() ? "true" : value);
    option->run_callback();
  }
  return saved;
}

}  // namespace sluice
