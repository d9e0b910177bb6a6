// The help of the program and of each command.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "tests/tools/parsed_commands.h"
#include "tests/tools/program.h"
#include "tools/command_line/help.h"
#include "tools/command_line/option_group.h"

namespace sluice {
namespace {

std::vector<std::string> linesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Help, groupsHoldAtMostTwelveOptionsWithNamedValues) {
  const CommandLine line = makeCommandLine();
  ASSERT_GE(commandsOf(line).size(), 15U);
  for (const Place& place : commandsOf(line)) {
    std::map<std::string, size_t> sizes;
    for (const CLI::Option* option : place.app->get_options()) {
      const std::string name = place.app->get_name() + " " + option->get_name();
      ++sizes[option->get_group()];
      if (isIdle(*place.app, *option)) continue;
      EXPECT_FALSE(option->get_group().empty()) << name;
      EXPECT_FALSE(option->get_description().empty()) << name;
      if (option->get_expected_max() == 0) continue;
      const std::string value = option->get_type_name();
      EXPECT_FALSE(value.empty() || value == "TEXT" || value == "INT" || value == "FLOAT") << name;
    }
    for (const auto& [group, size] : sizes)
      EXPECT_LE(size, OptionGroup::kMostOptions) << place.app->get_name() << " " << group;
  }
}

TEST(Help, fitsAHundredColumnsAndShowsDefaults) {
  const CommandLine line = makeCommandLine();
  for (const Place& place : commandsOf(line))
    for (const std::string& shown : linesOf(place.app->help("", CLI::AppFormatMode::All)))
      EXPECT_LE(shown.size(), kHelpColumns) << place.app->get_name() << ": " << shown;
  const std::string help = line.program->get_subcommand("render")->help();
  for (const char* part : {"-s, --size WxH", "[512x512]", "-t, --threshold VALUE", "-o, --output",
                           "-j, --threads", "composite, mip, minip,", "[composite]",
                           "Look:", "View:", "Drawing:", "Output:", "Volume:"})
    EXPECT_NE(help.find(part), std::string::npos) << part;
}

// --help of the commands with most options has the common ones, --help-all every one.
TEST(Help, isShortAndHelpAllIsWhole) {
  const Program program;
  for (const char* name : {"render", "view", "plan"}) {
    const std::string command(name);
    const std::string brief = program.run(command + " --help").output;
    const std::string whole = program.run(command + " --help-all").output;
    const CommandLine line = makeCommandLine();
    size_t options = 0, listed = 0;
    for (const CLI::Option* option : line.program->get_subcommand(command)->get_options()) {
      if (option->get_positional() || option->get_group().empty()) continue;
      const std::string shown = "--" + option->get_lnames().front();
      const auto isIn = [&](const std::string& text) {
        for (const std::string& each : linesOf(text))
          if (each.size() > 6 && (each + " ").substr(6).starts_with(shown + " ") &&
              each.substr(4, 2).find_first_not_of(", ") == std::string::npos)
            return true;
        return false;
      };
      EXPECT_TRUE(isIn(whole)) << command << " " << shown;
      ++options;
      if (isIn(brief)) ++listed;
    }
    EXPECT_LE(listed, 45U) << command;
    const std::string rest =
        fmt::format("\n{} more options: sluice {} --help-all\n", options - listed, command);
    EXPECT_NE(brief.find(rest), std::string::npos) << brief;
  }
  EXPECT_EQ(program.run("info --help-all").status, 2);
}

// The options that --help of render shows, by hand: whether an option is rare is said where it is
// described, and here a wrong word about it shows.
TEST(Help, hasTheOptionsThatPicturesOftenNeed) {
  const std::set<std::string> often = {
      "--annotate", "--azimuth", "--background", "--channel",   "--clip",        "--crop",
      "--device",   "--dims",    "--elevation",  "--force",     "--frames",      "--help",
      "--help-all", "--iso",     "--json",       "--keep-thin", "--label",       "--labels",
      "--levels",   "--look",    "--map",        "--memory",    "--mode",        "--no-shade",
      "--opacity",  "--output",  "--over",       "--path",      "--progressive", "--projection",
      "--quiet",    "--range",   "--report",     "--shade",     "--size",        "--spacing",
      "--state",    "--threads", "--threshold",  "--time",      "--time-limit",  "--transfer",
      "--type",     "--view",    "--zoom"};
  std::set<std::string> listed;
  for (const std::string& line : linesOf(Program().run("render --help").output))
    if (const size_t at = line.find("--"); at == 6)
      listed.insert(line.substr(at, line.find(' ', at) - at));
  EXPECT_EQ(listed, often);
}

TEST(Help, theOverviewIsTwentyFiveLinesThatNameEveryCommand) {
  const CommandLine line = makeCommandLine();
  const std::string text = overview(*line.program);
  EXPECT_LE(linesOf(text).size(), 25U);
  for (const std::string& shown : linesOf(text)) EXPECT_LE(shown.size(), kHelpColumns) << shown;
  for (const CLI::App* command :
       line.program->get_subcommands([](const CLI::App*) { return true; }))
    EXPECT_NE(text.find("\n  " + command->get_name() + " "), std::string::npos)
        << command->get_name();
}

TEST(Help, sayingNothingOrHelpPrintsTheOverview) {
  const Program program;
  const CommandResult nothing = program.run("");
  EXPECT_EQ(nothing.status, 0);
  EXPECT_NE(nothing.output.find("  render "), std::string::npos) << nothing.output;
  for (const char* words : {"help", "-h", "--help"})
    EXPECT_EQ(program.run(words).output, nothing.output) << words;
  EXPECT_EQ(program.run("help render").output, program.run("render --help").output);
  EXPECT_EQ(program.run("help bench limit").output, program.run("bench limit -h").output);
  EXPECT_EQ(program.run("-V").output, program.run("--version").output);
}

}  // namespace
}  // namespace sluice
