#include "src/view/state/printed_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "src/base/files/shell_word.h"
#include "src/base/looks/color_word.h"
#include "src/options/option_table.h"

namespace sluice {
namespace {

template <class List>
std::string listed(const List& values) {
  std::string text;
  for (const auto& value : values) text += fmt::format("{}{}", text.empty() ? "" : ",", value);
  return text;
}

// Values as the command line takes them.
std::string textOf(const std::string& text) {
  return text;
}
template <class Number>
std::string textOf(Number number) {
  return fmt::format("{}", number);
}
template <class Number>
std::string textOf(const std::vector<Number>& numbers) {
  return listed(numbers);
}
std::string textOf(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, ","));
}
std::string textOf(const std::vector<OptionReals>& points) {
  std::string text;
  for (const OptionReals& pair : points)
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", pair[0], pair[1]);
  return text;
}

void addWords(std::vector<OptionWord>& words, const OptionEntry& entry, const OptionValue& value) {
  if (!entry.kind.needs.empty()) words.emplace_back(entry.kind.needs, "");
  if (!entry.kind.flags.empty()) {
    const auto at =
        std::find(entry.kind.words.begin(), entry.kind.words.end(), std::get<std::string>(value));
    const auto flag = entry.kind.flags[static_cast<size_t>(at - entry.kind.words.begin())];
    if (!flag.empty()) words.emplace_back(flag, "");
  } else if (entry.kind.form == OptionForm::kFlag) {
    words.emplace_back(entry.option, "");
  } else if (entry.kind.form == OptionForm::kColor) {
    words.emplace_back(entry.option, colorWord(std::get<OptionReals>(value)));
  } else if (entry.kind.form == OptionForm::kPlanes) {
    for (const OptionReals& plane : std::get<std::vector<OptionReals>>(value))
      words.emplace_back(entry.option, listed(plane));
  } else if (entry.kind.form == OptionForm::kChannels || entry.kind.form == OptionForm::kLabels) {
    for (const std::string& look : std::get<std::vector<std::string>>(value))
      words.emplace_back(entry.option, look);
  } else {
    words.emplace_back(entry.option,
                       std::visit([](const auto& held) { return textOf(held); }, value));
  }
}

// The words of the entries of these parts.
std::vector<OptionWord> wordsOf(const ViewState& state, std::initializer_list<OptionPart> parts) {
  std::vector<const OptionEntry*> entries;
  for (const OptionEntry& entry : optionTable())
    if (!entry.option.empty() && std::find(parts.begin(), parts.end(), entry.part) != parts.end())
      entries.push_back(&entry);
  std::sort(entries.begin(), entries.end(),
            [](const OptionEntry* a, const OptionEntry* b) { return a->turn < b->turn; });
  std::vector<OptionWord> words;
  for (const OptionEntry* entry : entries)
    if (entry->is_printed == nullptr || entry->is_printed(state))
      if (const auto value = savedValue(*entry, state)) addWords(words, *entry, *value);
  return words;
}

// A name that begins as options do.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

}  // namespace

std::vector<OptionWord> volumeWords(const VolumeOptions& options) {
  std::vector<OptionWord> words;
  if (options.dims)
    words.emplace_back("--dims",
                       listed(*options.dims) +
                           (options.time_steps ? fmt::format(",{}", *options.time_steps) : ""));
  if (!options.type.empty()) words.emplace_back("--type", options.type);
  if (options.big_endian) words.emplace_back("--endian", "big");
  if (options.skip_bytes != 0) words.emplace_back("--skip", fmt::format("{}", options.skip_bytes));
  if (options.spacing) words.emplace_back("--spacing", listed(*options.spacing));
  if (!options.grid.empty()) words.emplace_back("--grid", options.grid);
  if (options.channel) words.emplace_back("--channel", fmt::format("{}", *options.channel));
  if (!options.channel && !options.channel_name.empty())
    words.emplace_back("--channel", options.channel_name);
  if (!options.over.empty()) words.emplace_back("--over", asOperand(options.over));
  return words;
}

std::vector<OptionWord> lookWords(const LookOptions& look) {
  ViewState state;
  state.look = look;
  return wordsOf(state, {OptionPart::kLook});
}

std::vector<OptionWord> pictureWords(const ViewState& state) {
  return wordsOf(state, {OptionPart::kCamera, OptionPart::kTop});
}

std::string renderCommand(const ViewedVolume& volume, const ViewState& state,
                          const std::string& look, int width, int height,
                          const std::string& output) {
  std::string command = "sluice render";
  for (const std::string& path : volume.paths) command += " " + shellWord(asOperand(path));
  const auto add = [&](const std::vector<OptionWord>& words) {
    // A single word each, so that a value may begin with a minus.
    for (const auto& [option, value] : words)
      command += " " + (value.empty() ? option : option + "=" + shellWord(value));
  };
  add(volumeWords(volume.options));
  if (look.empty()) {
    add(lookWords(state.look));
  } else {
    command += " " + look;
    const auto words = lookWords(state.look);
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
