// The command line in the parser: the options, and the words that they accept.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <set>

#include "src/options/option_table.h"
#include "tests/tools/parsed_commands.h"
#include "tests/tools/program.h"
#include "tools/command_line/near_miss.h"
#include "tools/command_line/number.h"

namespace sluice {
namespace {

TEST(CommandLine, aCommandAloneIsTheSameAsAmongAll) {
  const CommandLine all = makeCommandLine();
  ASSERT_GE(all.commands.size(), 12U);
  for (const auto& [command, run] : all.commands) {
    const CommandLine alone = makeCommandLine(command->get_name());
    ASSERT_EQ(alone.commands.size(), 1U);
    EXPECT_EQ(alone.program->get_subcommands(nullptr).size(), 1U);
    EXPECT_EQ(alone.commands.front().first->help("", CLI::AppFormatMode::All),
              command->help("", CLI::AppFormatMode::All));
  }
  for (const char* no_command : {"", "ren", "--version", "image.zarr"})
    EXPECT_EQ(makeCommandLine(no_command).commands.size(), all.commands.size()) << no_command;
}

// A complaint names other commands, which the program makes for it alone.
TEST(CommandLine, theProgramsComplaintKnowsAllCommands) {
  const Program program;
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"info", "a.nrrd", "--threshold", "3"},
        {"packk", "a.nrrd"},
        {"doctor", "--voxels"}})
    EXPECT_EQ(program.run(fmt::format("{}", fmt::join(words, " "))).output,
              "sluice: " + complaint(words) + "\n");
}

// Texts that are no sensible number, and the options that accept one of them anyway.
TEST(CommandLine, noOptionTakesANumberOutsideItsRange) {
  const std::set<std::string> signed_angles = {"--azimuth", "--elevation"};
  const auto takes = [&](const std::string& command, const std::string& option,
                         const std::string& word) {
    // Any value that is finite, and of surfaces several.
    if (option == "--threshold" || option == "--iso")
      return parseReal(word).has_value() ||
             (option == "--iso" && command != "surface" && word.starts_with("0,"));
    // A word that is no number is a name.
    if (option == "--channel") return word.find_first_not_of("+-0123456789") != std::string::npos;
    return signed_angles.contains(option) && word == "-1";
  };
  const std::set<std::string> texts = {"FILE", "FILE,...", "DIR.zarr", "DIR"};
  const std::set<std::string> names = {"--grid", "--unit", "--over"};
  const CommandLine line = makeCommandLine();
  size_t tried = 0;
  for (const Place& place : commandsOf(line))
    for (const CLI::Option* option : place.app->get_options()) {
      if (option->get_positional() || option->get_expected_max() == 0) continue;
      if (isIdle(*place.app, *option)) continue;
      const std::string name = "--" + option->get_lnames().front();
      for (const std::string word :
           {"", "nan", "inf", "-inf", "1e30", "99999999999999999999", "-1", "0x10", "1e", " 1",
            "1,", "1 2", "18446744073709551616", "-9223372036854775809", "0,0,0,1e30,1e30,1e30"}) {
        const bool is_text = texts.contains(option->get_type_name()) || names.contains(name);
        if (is_text && !word.empty()) continue;
        std::vector<std::string> words = place.words;
        words.insert(words.end(), {name, word});
        const std::string said = complaint(line, words);
        ++tried;
        if (takes(place.app->get_name(), name, word)) {
          EXPECT_EQ(said, "") << name << " " << word;
          continue;
        }
        ASSERT_NE(said, "") << place.app->get_name() << " " << name << " '" << word << "'";
        EXPECT_TRUE(said.starts_with(name + ": expected ")) << said;
        // For a list of names, the message shows the unknown one.
        const std::string first = word.substr(0, word.find(','));
        const auto finds = [&](const std::string& found) {
          return said.find("found '" + found + "'") != std::string::npos;
        };
        EXPECT_TRUE(finds(word) || finds(first)) << said;
        // The message must not print the ends of a type as 309 digits.
        EXPECT_LE(said.size(), 300U) << said;
      }
    }
  EXPECT_GT(tried, 2000U);
}

TEST(CommandLine, aRefusedNumberIsAnsweredWithTheRange) {
  const std::vector<std::tuple<std::string, std::string, std::string>> cases = {
      {"render --frames", "99999999999999999999", "a whole number from 1 to 100000"},
      {"render --seed", "-1", "a whole number from 0 to 18446744073709551615"},
      {"render --memory", "0", "a size above 0"},
      {"render --time-limit", "nan", "a number from 0 to 1e+09"},
      {"render --threshold", "", "a number"},
      {"render --crop", "0,0,0,1e30,1e30,1e30", "from 0 to 2^40"},
      {"render --page", "65536x1x1", "each from 1 to 1024"},
      {"render --pages", "4294967296", "a power of two from 1 to 2147483648"},
      {"render --pages", "100", "a power of two from 1 to 2147483648"},
      {"render --step", "0", "a number above 0, up to 1e+06"},
      {"render --size", "0", "in whole pixels"},
      {"render --block", "3", "a power of two from 4 to 1024"},
      {"render --opacity", "1.01", "a number from 0 to 1"},
      {"render --threads", "-1", "a whole number from 0 to 1024"},
      {"info --skip", "-1", "a whole number from 0 to"},
      {"info --dims", "0,1,1", "each from 1 to 2^40"},
      {"synth --share", "2", "a number from 0 to 1"},
      {"pack --level", "10", "a whole number from 1 to 9"},
      {"simulate --sizes", "0", "each from 1 to 2^40"}};
  for (const auto& [option, word, range] : cases) {
    std::vector<std::string> words = {option.substr(0, option.find(' ')),
                                      option.substr(option.find(' ') + 1), word};
    const std::string said = complaint(words);
    EXPECT_NE(said.find(range), std::string::npos) << option << " " << word << ": " << said;
  }
}

TEST(CommandLine, numbersAreTakenWholeAtBothEndsOfTheirRange) {
  for (const char* words :
       {"--frames 1", "--frames 100000", "--seed 0", "--seed 18446744073709551615", "--opacity 0",
        "--opacity 1", "--block 4", "--block 1024", "--pages 1", "--pages 2147483648", "--memory 1",
        "--time-limit 0", "--fov 179", "--page 1024x1x1", "--threshold -1e300", "--step 1e6",
        "--type uint8", "--crop 0,0,0,1099511627776,2,2", "--azimuth -30"}) {
    const std::string text = words;
    const size_t space = text.find(' ');
    EXPECT_EQ(complaint({"render", text.substr(0, space), text.substr(space + 1)}), "") << words;
    EXPECT_EQ(complaint({"render", text.substr(0, space) + "=" + text.substr(space + 1)}), "")
        << words;
  }
}

TEST(CommandLine, aNearMissIsAnsweredWithTheRightWord) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"rendr a.nii", "did you mean sluice render?"},
      {"sythn cube", "did you mean sluice synth?"},
      {"bench renderer", "did you mean sluice bench render?"},
      {"render --treshold 4", "did you mean --threshold?"},
      {"render --colormap x", "--map"},
      {"render --outptu a.png", "did you mean --output?"},
      {"render --mode mipp", "did you mean mip?"},
      {"render --mode vr", "composite, mip, minip, average, attenuated-mip or depth-mip"},
      {"render --map viridus", "did you mean viridis?"},
      {"render --map #ff88", "or white, or one colour as RRGGBB, found '#ff88'"},
      {"render --policy arcs", "did you mean arc?"},
      {"simulate --policies lru,beladi", "did you mean belady?"},
      {"synth phantm", "did you mean phantom?"},
      {"render --codec lz4", "pack has it"},
      {"view --level 3",
       "sluice view has no option --level; render, surface, plan, pack or simulate have it"},
      {"paint", "render, view, surface, info, plan"},
      {"synth:cube", "sluice render synth:cube -o picture.png"},
      {"bench", "limit, render"},
      {"render --size", "expected WxH after it"},
      {"render --size=", "expected WxH after the '='"},
      {"render --shadows=", "--shadows: expected a value after the '='"},
      {"render --force=x", "--force: expected no value, found 'x'"},
      {"render --labels=3", "--labels: expected no value, found '3'"},
      {"render --no-shade=false", "--no-shade: expected no value, found 'false'"},
      {"render --size 4 --size 5", "--size is given twice"},
      {"render -s 4 --size 5", "--size is given twice"},
      {"render --shadows --shadows=0", "--shadows is given twice"},
      {"render --jitter=0 --jitter", "--jitter is given twice"},
      {"render -x", "no option -x"}};
  for (const auto& [line, said] : cases) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    EXPECT_NE(complaint(words).find(said), std::string::npos) << line << ": " << complaint(words);
  }
}

TEST(CommandLine, refusesANameThatIsEmpty) {
  const CommandLine line = makeCommandLine();
  size_t found = 0;
  for (const Place& place : commandsOf(line))
    for (const CLI::Option* option : place.app->get_options()) {
      if (!option->get_positional() || option->get_name() == "kind") continue;  // a word of a list
      ++found;
      std::vector<std::string> words = place.words;
      words.insert(words.end(), {"", ""});
      EXPECT_EQ(complaint(words),
                option->get_name() + ": expected a name that is not empty, found ''");
    }
  EXPECT_GE(found, 10U);
}

TEST(CommandLine, refusesTwoLooksOfOneThing) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--look", "0:red", "--look", "0:green"}, "--look 0:green: channel 0 is given twice"},
      {{"--look", "over:red", "--look=over:,0:9"}, "--look over:,0:9: channel over is given twice"},
      {{"--label", "3=red", "--label", "3=green"}, "--label 3=green: label 3 is given twice"},
      {{"--label=3-7=red:0.5", "--label=3-7=:0.1"}, "--label 3-7=:0.1: label 3-7 is given twice"}};
  for (const auto& [options, said] : cases) {
    std::vector<std::string> words{"render", "a.nii", "-o", "a.png"};
    words.insert(words.end(), options.begin(), options.end());
    EXPECT_EQ(complaint(words), said);
  }
  // These add to each other.
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--look", "0:red", "--look", "1:green"},
        {"--label", "all=:0", "--label", "3=green:1"},
        {"--label", "3=green", "--label", "3=:0.5"}}) {
    std::vector<std::string> words{"render", "a.nii", "-o", "a.png"};
    words.insert(words.end(), options.begin(), options.end());
    EXPECT_EQ(complaint(words), "");
  }
}

TEST(CommandLine, refusesOptionsThatDoNotGoTogether) {
  const std::vector<std::vector<std::string>> apart = {
      {"--threshold=4", "--transfer=a.json"},
      {"--threshold=4", "--opacities=1:0,2:1"},
      {"--opacities=1:0,2:1", "--opacity=0.5"},
      {"--threshold=4", "--labels"},
      {"--threshold=4", "--labels-table=a.txt"},
      {"--threshold=4", "--label=1=red"},
      {"--transfer=a.json", "--labels"},
      {"--transfer=a.json", "--labels-table=a.txt"},
      {"--transfer=a.json", "--label=1=red"},
      {"--opacities=1:0,2:1", "--labels"},
      {"--opacities=1:0,2:1", "--labels-table=a.txt"},
      {"--opacities=1:0,2:1", "--label=1=red"},
      {"--iso=3", "--labels"},
      {"--iso=3", "--labels-table=a.txt"},
      {"--iso=3", "--label=1=red"},
      {"--shade", "--no-shade"},
      {"--eye=9,9,9", "--target=0,0,0", "--view=front"},
      {"--eye=9,9,9", "--target=0,0,0", "--azimuth=4"},
      {"--eye=9,9,9", "--target=0,0,0", "--elevation=4"},
      {"--eye=9,9,9", "--target=0,0,0", "--fit=volume"},
      {"--level=1", "--pixel-error=2"},
      {"--level=1", "--max-bytes=1M"},
      {"--level=1", "--keep-thin"}};
  for (const std::vector<std::string>& options : apart) {
    std::vector<std::string> words{"render", "synth:cube", "-o", "a.png"};
    words.insert(words.end(), options.begin(), options.end());
    EXPECT_NE(complaint(words).find("excludes"), std::string::npos) << options.back();
    words.pop_back();
    EXPECT_EQ(complaint(words), "");
  }
  EXPECT_EQ(complaint({"render", "a", "-o", "b", "--transfer=a.json", "--opacities=1:0,2:1"}), "");
  for (const char* alone : {"--eye=9,9,9", "--target=0,0,0", "--full-gradient=0.2"})
    EXPECT_THROW(makeCommandLine().program->parse({alone, "-o=b", "a", "render"}),
                 CLI::RequiresError)
        << alone;
}

TEST(CommandLine, valuesMayLookLikeOptionsAndCommands) {
  EXPECT_EQ(complaint({"render", "info", "-o", "-strange.png", "--azimuth", "-5"}), "");
  EXPECT_EQ(complaint({"render", "a.nii", "-ob.png", "-j4", "-s64"}), "");
  EXPECT_EQ(complaint({"render", "-o", "b.png", "--", "--odd-name.raw"}), "");
}

TEST(CommandLine, distancesAreThoseOfInsertingDeletingReplacingAndSwapping) {
  EXPECT_EQ(editDistance("", "abc"), 3U);
  EXPECT_EQ(editDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(editDistance("smal", "slam"), 2U);
  EXPECT_EQ(editDistance("outptu", "output"), 1U);
  EXPECT_EQ(editDistance("MIP", "mip"), 0U);
  EXPECT_EQ(nearest("zebra", {"lion", "tiger"}), "");
}

TEST(CommandLine, aFlagsWrongValueIsNamedOnce) {
  const Program program;
  size_t tried = 0;
  for (const OptionEntry& entry : optionTable()) {
    if (entry.kind.bare.empty()) continue;
    ++tried;
    const std::string option(entry.option);
    EXPECT_EQ(program.run("render synth:cube -o a.png " + option + "=2").output,
              "sluice: " + option + ": expected a number from 0 to 1, found '2'\n");
  }
  EXPECT_GE(tried, 4U);
}

TEST(CommandLine, aFullDeviceOrAClosedOutputIsStatusOne) {
  const Program program;
  const std::string trace = "t.trace";
  ASSERT_EQ(
      program.run(std::string("render ") + kSmall + " -o a.png --size 16 --trace " + trace).status,
      0);
  ASSERT_EQ(program.run(std::string("pack ") + kSmall + " -o a.zarr").status, 0);
  const std::string volume = kSmall;
  const std::vector<std::string> lines = {"help",
                                          "--version",
                                          "render --help",
                                          "info " + volume,
                                          "plan " + volume,
                                          "render " + volume + " -o b.png --size 16",
                                          "simulate " + trace,
                                          "synth cube --dims 8,8,8 -o c.nrrd",
                                          "pack --check a.zarr",
                                          "fetch --list",
                                          "doctor",
                                          "bench slicing"};
  for (const std::string& line : lines)
    for (const std::string json : {"", " --json"}) {
      if (!json.empty() && (line.find("-h") != std::string::npos || line.starts_with("help") ||
                            line.starts_with("--")))
        continue;
      for (const std::string device : {" >/dev/full", " >&-"}) {
        const CommandResult result = program.run(line + json + device);
        EXPECT_EQ(result.status, 1) << line << json << device << ": " << result.output;
        EXPECT_NE(result.output.find("standard output"), std::string::npos) << result.output;
      }
    }
}

TEST(CommandLine, standardErrorThatTakesNothingChangesNoStatus) {
  const Program program;
  for (const std::string device : {" 2>&-", " 2>/dev/full"}) {
    EXPECT_EQ(program.run("info missing.nrrd" + device).status, 1) << device;
    EXPECT_EQ(program.run("rendr" + device).status, 2) << device;
    EXPECT_EQ(program.run(std::string("info ") + kSmall + device).status, 0) << device;
    EXPECT_EQ(program.run(std::string("info ") + kSmall + device + " <&-").status, 0) << device;
  }
}

}  // namespace
}  // namespace sluice
