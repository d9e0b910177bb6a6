#include "src/view/state/printed_command.h"

#include <fmt/format.h>

#include "src/base/files/shell_word.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"

namespace sluice {
namespace {

// A name that begins as options do.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

}  // namespace

std::vector<OptionWord> lookWords(const LookOptions& look) {
  ViewState state;
  state.look = look;
  return optionWords(state,
                     [](const OptionEntry& entry) { return entry.part == OptionPart::kLook; });
}

std::vector<OptionWord> pictureWords(const ViewState& state) {
  return optionWords(state,
                     [](const OptionEntry& entry) { return entry.part != OptionPart::kLook; });
}

std::string renderCommand(const ViewedVolume& volume, const ViewState& whole,
                          const std::string& look, int width, int height,
                          const std::string& output) {
  // The command line refuses options that have no effect together.
  const ViewState state = withoutConflicts(whole);
  std::string command = "sluice render";
  for (const std::string& path : volume.paths) command += " " + shellWord(asOperand(path));
  const auto add = [&](const std::vector<OptionWord>& words) { command += optionsText(words); };
  // The look of several channels names them.
  VolumeOptions options = volume.options;
  if (look.starts_with("--channel ")) {
    options.channel.reset();
    options.channel_name.clear();
  }
  add(volumeWords(options));
  if (look.empty()) {
    add(lookWords(state.look));
  } else {
    command += " " + look;
    const auto words = lookWords(state.look);
    // The printed look has all of the look but the mode, which decides how it is used.
    add({words.back()});  // the mode
  }
  ViewState of_look = state;
  if (look.find("--no-shade") != std::string::npos) of_look.look.light = LookOptions::Light::kOff;
  add(pictureWords(of_look));
  // Levels of another program, which the program draws on request alone.
  const LookOptions& shown = state.look;
  const bool has_labels = shown.labels || !shown.label_table.empty() || !shown.label_looks.empty();
  if (volume.options.opens_soon && shown.mode == LookOptions::Mode::kComposite && !has_labels &&
      shown.surfaces.empty())
    command += " --pixel-error=1";
  return command + fmt::format(" --size {}x{} -o {}", width, height, shellWord(asOperand(output)));
}

std::string framesCommand(const std::string& state_file, int width, int height,
                          const std::string& output) {
  return fmt::format("sluice render --state={} --size {}x{} -o {}", shellWord(state_file), width,
                     height, shellWord(asOperand(output)));
}

}  // namespace sluice
