#include "src/options/option_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "src/base/files/shell_word.h"
#include "src/base/looks/color_word.h"

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

template <class Subject>
void addWords(std::vector<OptionWord>& words, const EntryOf<Subject>& entry,
              const OptionValue& value) {
  if (!entry.kind.needs.empty()) words.emplace_back(entry.kind.needs, "");
  if (!entry.kind.flags.empty()) {
    const auto at =
        std::find(entry.kind.words.begin(), entry.kind.words.end(), std::get<std::string>(value));
    // The first word of a list is the default and has no flag.
    const auto flag = entry.kind.flags[static_cast<size_t>(at - entry.kind.words.begin())];
    if (!flag.empty()) words.emplace_back(flag, "");
  } else if (entry.kind.form == OptionForm::kFlag) {
    const auto& named = entry.kind.words;
    words.emplace_back(entry.option, named.empty() ? "" : named[std::get<bool>(value) ? 1 : 0]);
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

}  // namespace

std::vector<OptionWord> optionWords(const ViewState& state,
                                    const std::function<bool(const OptionEntry&)>& takes) {
  std::vector<const OptionEntry*> entries;
  for (const OptionEntry& entry : optionTable())
    if (!entry.option.empty() && takes(entry)) entries.push_back(&entry);
  // The order in which people read a command, which differs from that of the table.
  std::sort(entries.begin(), entries.end(),
            [](const OptionEntry* a, const OptionEntry* b) { return a->turn < b->turn; });
  std::vector<OptionWord> words;
  for (const OptionEntry* entry : entries)
    if (entry->is_printed == nullptr || entry->is_printed(state))
      if (const auto value = savedValue(*entry, state)) addWords(words, *entry, *value);
  return words;
}

std::vector<OptionWord> volumeWords(const VolumeOptions& options) {
  std::vector<OptionWord> words;
  for (const VolumeEntry& entry : volumeTable())
    if (const auto value = savedValue(entry, options); value && !entry.option.empty())
      addWords(words, entry, *value);
  return words;
}

std::vector<OptionWord> lightWords(const ViewState& state) {
  return optionWords(state, [](const OptionEntry& entry) { return entry.is_light; });
}

std::string optionsText(const std::vector<OptionWord>& words) {
  std::string text;
  for (const auto& [option, value] : words)
    text += " " + (value.empty() ? option : option + "=" + shellWord(value));
  return text;
}

}  // namespace sluice
