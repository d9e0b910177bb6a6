#include <fmt/format.h>

#include "tools/command_line/option_group.h"
#include "tools/manual/completions.h"

namespace sluice {
namespace {

std::string fishQuoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    // Only these two have a meaning between single quotes in fish.
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result + "'";
}

// The condition under which the words before the cursor name the command.
std::string fishCondition(const CommandText& command, const CommandText& program) {
  for (const CommandText& each : program.commands)
    for (const CommandText& below : each.commands)
      if (&below == &command)
        return fmt::format("__sluice_command {} {}", lastWord(each), lastWord(command));
  return "__sluice_command " + lastWord(command);
}

std::string fishValue(const OptionText& option) {
  if (option.value.empty()) return "";
  const std::string words = joined(option.words, " ");
  if (!words.empty() && option.is_list)
    return fmt::format(" -x -a '(__fish_complete_list , \"string join \\\\n {}\")'", words);
  if (!words.empty()) return " -x -a " + fishQuoted(words);
  return isFile(option) ? " -r -F" : " -x";
}

std::string fishOption(const OptionText& option, const std::string& begin) {
  std::string text = begin;
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return text + fishValue(option) + " -d " + fishQuoted(firstClause(option.help)) + "\n";
}

}  // namespace

std::string fishCompletion(const CommandText& program) {
  std::string text =
      "# Completion for sluice(1), made of its --help.\n\n"
      "function __sluice_command --description 'Whether these are the first words'\n"
      "    set -l words (commandline -opc)\n"
      "    set -l last (math 1 + (count $argv))\n"
      "    test (count $words) -ge $last; and test \"$words[2..$last]\" = \"$argv\"\n"
      "end\n"
      "function __sluice_needs_command --description 'Whether a command is missing after these'\n"
      "    set -l words (commandline -opc)\n"
      "    set -e words[1]\n"
      "    test \"$words\" = \"$argv\"\n"
      "end\n"
      "complete -c sluice -f\n";
  for (const CommandText* command : withCommandsBelow(program)) {
    const std::string words = command == &program ? "" : " " + lastWord(*command);
    for (const CommandText& below : command->commands)
      text += fmt::format("complete -c sluice -n '__sluice_needs_command{}' -a {} -d {}\n", words,
                          lastWord(below), fishQuoted(firstClause(below.summary)));
    if (!command->commands.empty()) continue;
    const std::string begin = "complete -c sluice -n '" + fishCondition(*command, program) + "'";
    for (const OptionText& argument : command->arguments) {
      if (!argument.words.empty())
        text += begin + " -a " + fishQuoted(joined(argument.words, " ")) + "\n";
      else if (isFile(argument))
        text += begin + " -F\n";
    }
    for (const OptionHeading& heading : command->headings)
      for (const OptionText& option : heading.options) text += fishOption(option, begin);
  }
  return text;
}

}  // namespace sluice
