#include "tools/command_line/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

namespace sluice {
namespace {

constexpr size_t kNamesColumns = 30;  // left column; longer names have a line of their own

// Commands whose --help is short.
constexpr std::array<std::string_view, 3> kDrawing = {"render", "view", "plan"};

std::string firstLine(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// "  -s, --size WxH", or "      --step VOXELS".
std::string namesOf(const CLI::Option& option) {
  if (option.get_positional()) return "  " + option.get_type_name();
  const auto& shorts = option.get_snames();
  std::string text = shorts.empty() ? "      " : "  -" + shorts.front() + ", ";
  text += "--" + option.get_lnames().front();
  if (option.get_expected_max() != 0) text += " " + option.get_type_name();
  return text;
}

std::string lineOf(const CLI::Option& option) {
  std::string text = namesOf(option);
  std::string help = option.get_description();
  if (!option.get_default_str().empty()) help += " [" + option.get_default_str() + "]";
  if (option.get_required() && !option.get_positional()) help += " (required)";
  if (text.size() + 2 > kNamesColumns)
    text += "\n" + std::string(kNamesColumns, ' ');
  else
    text.resize(kNamesColumns, ' ');
  return text + wrapped(help, kNamesColumns, kHelpColumns) + "\n";
}

// The description within the columns; lines that are indented stay as they are.
std::string described(const CLI::App& app) {
  std::istringstream lines(app.get_description());
  std::string text;
  for (std::string line; std::getline(lines, line);)
    text += (line.starts_with(' ') ? line : wrapped(line, 0, kHelpColumns)) + "\n";
  return text;
}

}  // namespace

void noteRare(const CLI::App& app, const CLI::Option& option) {
  if (auto* const formatter = dynamic_cast<HelpFormatter*>(app.get_formatter().get()))
    formatter->noteRare(app, option);
}

void HelpFormatter::noteRare(const CLI::App& app, const CLI::Option& option) {
  rare_.emplace(&app, option.get_name());
}

bool HelpFormatter::isShown(const CLI::App& app, const CLI::Option& option,
                            CLI::AppFormatMode mode) const {
  return mode == CLI::AppFormatMode::All || !hasShortHelp(app) ||
         !rare_.contains({&app, option.get_name()});
}

bool hasShortHelp(const CLI::App& command) {
  return command.get_parent() != nullptr && command.get_parent()->get_parent() == nullptr &&
         std::ranges::find(kDrawing, command.get_name()) != kDrawing.end();
}

std::string wrapped(const std::string& text, size_t indent, size_t columns) {
  std::istringstream words(text);
  std::string result, word;
  size_t column = indent;
  while (words >> word) {
    if (!result.empty() && column + 1 + word.size() > columns) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!result.empty()) {
      result += ' ';
      ++column;
    }
    result += word;
    column += word.size();
  }
  return result;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string /*name*/,
                                     CLI::AppFormatMode mode) const {
  std::string text = described(*app) + "\nUsage: " + fullName(*app);
  const auto positionals =
      app->get_options([](const CLI::Option* option) { return option->get_positional(); });
  for (const CLI::Option* option : positionals) {
    const bool many = option->get_expected_max() > 1;
    text += " " + option->get_type_name() + (many ? "..." : "");
  }
  const auto commands = app->get_subcommands([](const CLI::App*) { return true; });
  text += commands.empty() ? " [OPTION...]\n" : " COMMAND [OPTION...]\n";
  if (!commands.empty()) text += "\nCommands:\n";
  for (const CLI::App* command : commands) {
    std::string line = "  " + command->get_name();
    line.resize(14, ' ');
    text += line + wrapped(firstLine(command->get_description()), 14, kHelpColumns) + "\n";
  }
  size_t left_out = 0;
  for (const std::string& group : app->get_groups()) {
    const auto options =
        app->get_options([&](const CLI::Option* option) { return option->get_group() == group; });
    // CLI11 hides options of an empty group.
    if (group.empty()) continue;
    std::string lines;
    for (const CLI::Option* option : options) {
      if (isShown(*app, *option, mode))
        lines += lineOf(*option);
      else
        ++left_out;
    }
    if (!lines.empty()) text += fmt::format("\n{}:\n{}", group, lines);
  }
  if (left_out > 0)
    text += fmt::format("\n{} more options: {} --help-all\n", left_out, fullName(*app));
  return text;
}

std::string fullName(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return (parent == nullptr ? "" : fullName(*parent) + " ") + app.get_name();
}

std::string overview(const CLI::App& program) {
  std::string text = program.get_description() + "\n";
  std::string group;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group() != group) {
      group = command->get_group();
      text += fmt::format("\n{}:\n", group);
    }
    text += fmt::format("  {:<10}{}\n", command->get_name(), firstLine(command->get_description()));
  }
  return text +
         "\n`sluice COMMAND --help` has a command's options; most take -j THREADS and "
         "--json.\nSizes take K, M, G, T (powers of 1024). -V prints the version.\n";
}

}  // namespace sluice
