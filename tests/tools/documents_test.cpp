// docs/command-line.md is true: the program's environment variables, exit statuses, options.
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

std::string page() {
  return readFile(fs::path(SLUICE_SOURCE_DIR) / "docs" / "command-line.md");
}

std::set<std::string> matches(const std::string& text, const std::string& pattern) {
  const std::regex wanted(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), wanted), end; at != end; ++at)
    found.insert((*at)[1]);
  return found;
}

// The text after the heading, up to the next one.
std::string section(const std::string& text, const std::string& heading) {
  const size_t at = text.find("## " + heading);
  if (at == std::string::npos) throw Error("no section " + heading);
  return text.substr(at, text.find("\n## ", at + 1) - at);
}

TEST(CommandLinePage, namesEveryEnvironmentVariableThatTheSourcesAskForAndNoOther) {
  std::set<std::string> asked;
  for (const char* folder : {"src", "io", "cache", "tools"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SLUICE_SOURCE_DIR) / folder))
      if (entry.path().extension() == ".cpp")
        asked.merge(matches(readFile(entry.path()),
                            "(?:getenv|setenv|folderFrom|textFrom|variable)\\(\"([A-Z_]+)\""));
  ASSERT_GE(asked.size(), 5U);
  EXPECT_EQ(matches(section(page(), "Environment"), "\\n\\| `([A-Z_]+)`"), asked);
}

TEST(CommandLinePage, namesOptionsThatExist) {
  const Program program;
  std::string help;
  for (const char* words : {"render --help-all", "info -h", "simulate -h", "synth -h", "pack -h"})
    help += program.run(words).output;
  for (const std::string& option : matches(page(), "(--[a-z][a-z-]*)"))
    EXPECT_NE(help.find(option), std::string::npos) << option;
}

TEST(CommandLinePage, saysTheStatusOfEachSignal) {
  const Program program;
  const auto statuses = matches(section(page(), "Exit status"), "\\n\\| (\\d+) \\|");
  for (const auto& [signal, status] : {std::pair("INT", 130), {"TERM", 143}, {"HUP", 129}}) {
    EXPECT_TRUE(statuses.contains(std::to_string(status)));
    const CommandResult result = program.signalled("synth noise -o big.raw --dims 3000,3000,3000",
                                                   signal, "[ -e big.raw.0.tmp ]");
    EXPECT_EQ(result.status, status) << signal << ": " << result.output;
    EXPECT_NE(result.output.find("interrupted"), std::string::npos) << result.output;
    EXPECT_TRUE(fs::is_empty(program.folder.path())) << signal;
  }
  const CommandResult ignored = program.signalled("synth noise -o some.raw --dims 200,200,200",
                                                  "HUP", "[ -e some.raw.0.tmp ]", "trap '' HUP; ");
  EXPECT_EQ(ignored.status, 0) << ignored.output;
}

}  // namespace
}  // namespace sluice
