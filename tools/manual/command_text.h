// The commands and options of the program as plain text: the same words as --help, from the same
// place, for everything that is made of them (manual pages, completions).
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace sluice {

struct OptionText {
  std::vector<std::string> names;  // "-s", "--size"; none: an argument without a name
  std::string value;               // "WxH"; empty: a flag
  std::string help;
  std::string default_value;       // empty: none is shown
  std::vector<std::string> words;  // the only values, if they are a few words
  bool is_required = false;
  bool is_list = false;  // an argument that may be given several times, or words with commas
};

struct OptionHeading {
  std::string title;
  std::vector<OptionText> options;
};

struct CommandText {
  std::string name;         // "sluice bench render"
  std::string heading;      // of the list of commands that it stands in
  std::string summary;      // the first line of the description
  std::string description;  // the lines after it; examples are indented
  std::vector<OptionText> arguments;
  std::vector<OptionHeading> headings;
  std::vector<CommandText> commands;
};

// The program or one of its commands, with the commands below it.
CommandText commandText(CLI::App& app);

// Whether the value names a file or folder.
bool isFile(const OptionText& option);

// The command and all commands below it.
std::vector<const CommandText*> withCommandsBelow(const CommandText& command);

// The last word of its name.
std::string lastWord(const CommandText& command);

// The first clause of a help text, for lists of one line each.
std::string firstClause(const std::string& help);

}  // namespace sluice
