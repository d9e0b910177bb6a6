// The text of --help: options under the headings of their groups, defaults in brackets, within 100
// columns.
#pragma once

#include <CLI/CLI.hpp>

#include <set>
#include <string>
#include <utility>

namespace sluice {

inline constexpr size_t kHelpColumns = 100;

// For every command: the layout of its --help. A group's options stand in the order in which they
// were added. The commands that draw have so many that --help leaves out those that a picture
// rarely needs (mode Normal); --help-all has them all (mode All).
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;
  // A picture rarely needs this option. `app`: the command that has it.
  void noteRare(const CLI::App& app, const CLI::Option& option);

 private:
  bool isShown(const CLI::App& app, const CLI::Option& option, CLI::AppFormatMode mode) const;

  std::set<std::pair<const CLI::App*, std::string>> rare_;  // commands and names of options
};

// Tells the command's HelpFormatter, if it has one.
void noteRare(const CLI::App& app, const CLI::Option& option);

// A command whose --help leaves options out.
bool hasShortHelp(const CLI::App& command);

// The words that name a command on the command line: "sluice bench render".
std::string fullName(const CLI::App& app);

// What there is, in 25 lines: the commands by what they are for.
std::string overview(const CLI::App& program);

// `text` in lines of at most `columns`, each begun by `indent` spaces but the first.
std::string wrapped(const std::string& text, size_t indent, size_t columns);

}  // namespace sluice
