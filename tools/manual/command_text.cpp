#include "tools/manual/command_text.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "tools/command_line/help.h"
#include "tools/command_line/option_group.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 9> kFileValues = {
    "FILE", "FILE,...", "DIR", "DIR.zarr", "VOLUME", "SERIES", "TRACE", "FOLDER", "INPUT"};

OptionText optionText(CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  if (option.get_positional()) text.names.clear();
  if (option.get_expected_max() != 0) text.value = option.get_type_name();
  text.help = option.get_description();
  text.default_value = option.get_default_str();
  text.words = offeredWords(option);
  text.is_required = option.get_required();
  text.is_list = text.names.empty() ? option.get_expected_max() > 1 : text.value.ends_with(",...");
  return text;
}

}  // namespace

CommandText commandText(CLI::App& app) {
  CommandText text;
  text.name = fullName(app);
  text.heading = app.get_group();
  const std::string description = app.get_description();
  const size_t end = std::min(description.find('\n'), description.size());
  text.summary = description.substr(0, end);
  text.description =
      description.substr(std::min(description.find_first_not_of('\n', end), description.size()));
  for (const std::string& group : app.get_groups()) {
    OptionHeading heading{group, {}};
    for (CLI::Option* option : app.get_options())
      if (!group.empty() && option->get_group() == group) {
        const OptionText made = optionText(*option);
        (made.names.empty() ? text.arguments : heading.options).push_back(made);
      }
    if (!heading.options.empty()) text.headings.push_back(std::move(heading));
  }
  for (CLI::App* command : app.get_subcommands(nullptr))
    text.commands.push_back(commandText(*command));
  return text;
}

bool isFile(const OptionText& option) {
  return std::ranges::find(kFileValues, option.value) != kFileValues.end();
}

std::vector<const CommandText*> withCommandsBelow(const CommandText& command) {
  std::vector<const CommandText*> all = {&command};
  for (const CommandText& below : command.commands)
    for (const CommandText* each : withCommandsBelow(below)) all.push_back(each);
  return all;
}

std::string lastWord(const CommandText& command) {
  return command.name.substr(command.name.rfind(' ') + 1);
}

std::string firstClause(const std::string& help) {
  size_t end = help.size();
  for (const char* const mark : {"; ", ". ", ": ", ", "}) {
    // A comma or a colon near the beginning leaves too little of the sentence.
    const size_t found = help.find(mark, mark[0] == ',' || mark[0] == ':' ? 24 : 0);
    end = std::min(end, found);
  }
  return help.substr(0, end);
}

}  // namespace sluice
