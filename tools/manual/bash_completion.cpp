#include <fmt/format.h>

#include "tools/command_line/option_group.h"
#include "tools/manual/completions.h"

namespace sluice {
namespace {

// The words before the cursor name the command; "--size=5" arrives as three words.
constexpr const char* kBashBegin = R"(# Completion for sluice(1), made of its --help.
_sluice()
{
    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} at words= files= options=
    local command=
    COMPREPLY=()
    if [[ $cur == = ]]; then
        cur=
    elif [[ $prev == = ]]; then
        prev=${COMP_WORDS[COMP_CWORD-2]}
    fi
    for ((at = 1; at < COMP_CWORD; ++at)); do
        case "$command ${COMP_WORDS[at]}" in
)";

constexpr const char* kBashEnd = R"(    if [[ $cur == -* ]]; then
        words=$options
        files=
    fi
    if [[ $files ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$cur")
    elif [[ $words == *,* ]]; then
        # Words with commas between: the last one is completed.
        local before=
        [[ $cur == *,* ]] && before=${cur%,*},
        mapfile -t COMPREPLY < <(compgen -P "$before" -W "${words//,/ }" -- "${cur##*,}")
        compopt -o nospace 2>/dev/null
    else
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
    fi
}
complete -F _sluice sluice
)";

// The value of an option, or an argument: files, words, or anything.
std::string bashValue(const OptionText& option) {
  if (!option.words.empty())
    return fmt::format("words='{}'", joined(option.words, option.is_list ? "," : " "));
  return isFile(option) ? "files=1" : ":";
}

std::string bashCase(const CommandText& command) {
  std::string options, values;
  for (const OptionHeading& heading : command.headings)
    for (const OptionText& option : heading.options) {
      for (const std::string& name : option.names)
        if (name.starts_with("--")) options += (options.empty() ? "" : " ") + name;
      if (!option.value.empty())
        // A word that begins with '-' after such an option is its value, not an option to complete.
        values += fmt::format("            {}) {}; options= ;;\n", joined(option.names, "|"),
                              bashValue(option));
    }
  std::string text = fmt::format("    '{}')\n        options='{}'\n",
                                 command.name.substr(command.name.find(' ')), options);
  text += "        case $prev in\n" + values + "            *) ";
  if (!command.commands.empty()) {
    std::string names;
    for (const CommandText& each : command.commands) names += lastWord(each) + " ";
    text += fmt::format("words='{}'", names);
  } else if (!command.arguments.empty()) {
    text += bashValue(command.arguments.front());
  } else {
    text += ":";
  }
  return text + " ;;\n        esac ;;\n";
}

}  // namespace

std::string bashCompletion(const CommandText& program) {
  std::string text = kBashBegin, names;
  const auto all = withCommandsBelow(program);
  // A command is known by its words alone, of which the program's name is the first.
  for (const CommandText* command : all)
    if (command != &program)
      names += fmt::format("{}'{}'", names.empty() ? "            " : "|",
                           command->name.substr(command->name.find(' ')));
  text += names +
          ") command+=\" ${COMP_WORDS[at]}\" ;;\n            *) break ;;\n        esac\n    done\n";
  text += "    case $command in\n";
  for (const CommandText* command : all) text += command == &program ? "" : bashCase(*command);
  std::string first;
  for (const CommandText& command : program.commands) first += lastWord(command) + " ";
  text += fmt::format("    *) words='{}help'; options='--help --version' ;;\n    esac\n", first);
  return text + kBashEnd;
}

}  // namespace sluice
