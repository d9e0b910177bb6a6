#include <fmt/format.h>

#include "tools/command_line/option_group.h"
#include "tools/manual/completions.h"

namespace sluice {
namespace {

// Text within single quotes, in which `special` characters have a backslash.
std::string zshQuoted(const std::string& text, const std::string& special) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      // A quote ends the text, stands by itself behind a backslash, and the text goes on.
      result += "'\\''";
      continue;
    }
    if (special.find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

std::string zshAction(const OptionText& option) {
  const std::string words = zshQuoted(joined(option.words, " "), "():");
  if (!option.words.empty() && option.is_list) return fmt::format("_values -s , value {}", words);
  if (!option.words.empty()) return "(" + words + ")";
  return isFile(option) ? "_files" : " ";
}

std::string zshMessage(const OptionText& option) {
  return zshQuoted(option.value, ":\\") + ":" + zshAction(option);
}

// One line of _arguments: '(-s --size)'{-s+,--size=}'[help]:WxH: '
std::string zshOption(const OptionText& option) {
  if (option.names.empty())
    return fmt::format("'{}:{}'", option.is_list ? "*" : "", zshMessage(option));
  std::vector<std::string> forms;
  for (const std::string& name : option.names)
    // "=" and "+" tell _arguments that the value may be a word of its own or follow at once.
    forms.push_back(option.value.empty() ? name : name + (name.starts_with("--") ? "=" : "+"));
  const std::string help = "[" + zshQuoted(firstClause(option.help), "[]:\\") + "]" +
                           (option.value.empty() ? "" : ":" + zshMessage(option));
  if (forms.size() == 1) return "'" + forms.front() + help + "'";
  return fmt::format("'({})'{{{}}}'{}'", joined(option.names, " "), joined(forms, ","), help);
}

std::string zshCommands(const CommandText& command, const std::string& indent) {
  std::string text = indent + "local -a commands=(\n";
  for (const CommandText& each : command.commands)
    text += fmt::format("{}  '{}:{}'\n", indent, lastWord(each),
                        zshQuoted(firstClause(each.summary), ":\\"));
  return text + indent + ")\n" + indent + "_describe command commands\n";
}

std::string zshCase(const CommandText& command, const std::string& indent) {
  std::string text = fmt::format("{}{})\n", indent, lastWord(command));
  if (command.commands.empty()) {
    text += indent + "  _arguments -s -S";
    for (const OptionText& argument : command.arguments)
      text += " \\\n" + indent + "    " + zshOption(argument);
    for (const OptionHeading& heading : command.headings)
      for (const OptionText& option : heading.options)
        text += " \\\n" + indent + "    " + zshOption(option);
    return text + "\n" + indent + "  ;;\n";
  }
  text += indent + "  if (( CURRENT == 2 )); then\n" + zshCommands(command, indent + "    ") +
          indent + "    return\n" + indent + "  fi\n" + indent + "  shift words\n" + indent +
          "  (( CURRENT-- ))\n" + indent + "  case $words[1] in\n";
  for (const CommandText& each : command.commands) text += zshCase(each, indent + "    ");
  return text + indent + "  esac\n" + indent + "  ;;\n";
}

}  // namespace

std::string zshCompletion(const CommandText& program) {
  std::string text =
      "#compdef sluice\n# Completion for sluice(1), made of its --help.\n\n_sluice() {\n"
      "  if (( CURRENT == 2 )); then\n" +
      zshCommands(program, "    ") +
      "    return\n  fi\n  shift words\n  (( CURRENT-- ))\n  case $words[1] in\n";
  for (const CommandText& command : program.commands) text += zshCase(command, "    ");
  return text + "  esac\n}\n\n_sluice \"$@\"\n";
}

}  // namespace sluice
