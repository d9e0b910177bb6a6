// File names from anywhere: none reaches the terminal as a command to it, and none that is printed
// runs as a command when it is pasted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// A newline, a word that would run, a terminal's sequence, and a byte that is no UTF-8.
const std::string kEvil = "a\ntouch pwned; \x1b[2J\xff '";

std::string quoted(const std::string& end) {
  return shellQuoted(kEvil + end);
}

void expectHarmless(const CommandResult& result, const std::string& line) {
  for (const char c : result.output)
    EXPECT_TRUE(c == '\n' || c == '\t' || static_cast<unsigned char>(c) >= 0x20) << line;
  EXPECT_EQ(result.output.find('\xff'), std::string::npos) << line;
  std::istringstream lines(result.output);
  for (std::string each; std::getline(lines, each);)
    EXPECT_FALSE(each.starts_with("touch")) << line << ": " << result.output;
}

TEST(Names, areHarmlessInEverythingThatIsPrinted) {
  const Program program;
  const std::string volume = quoted(".nrrd"), picture = quoted(".png"), store = quoted(".zarr"),
                    report = quoted(".json"), page = quoted(".html"), trace = quoted(".trace"),
                    look = quoted("look.json");
  writeFile(program.folder / (kEvil + "look.json"),
            R"({"sluice_transfer_function": 1, "map": "grey", "opacities": [[90, 0.1]]})");
  for (const std::string& line :
       {"synth shells --dims 24,20,16 -o " + volume, "info " + volume, "info --json " + volume,
        "render " + volume + " --size 16 -o " + picture + " --transfer " + look + " --report " +
            report + " --trace " + trace,
        "render " + volume + " --size 16 --json -o " + picture,
        "render " + volume + " --size 16 -o " + picture + " --report " + page, "plan " + volume,
        "simulate " + trace + " --csv " + quoted(".csv"), "pack " + volume + " -o " + store,
        "pack --check " + store,
        "bench report " + report + " " + report + " -o " + quoted("b.html"),
        "bench report " + report + " " + report}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 0) << line << ": " << result.output;
    expectHarmless(result, line);
  }
  for (const std::string& line :
       {"info " + quoted("none"),
        "render " + volume + " --transfer " + quoted("none") + " -o a.png",
        "synth cube -o " + picture, "render " + volume + " --map " + quoted("") + " -o a.png",
        quoted(""), "render --" + quoted("")}) {
    const CommandResult result = program.run(line);
    EXPECT_NE(result.status, 0) << line;
    expectHarmless(result, line);
  }
}

// Files of one name in two folders are told apart.
TEST(Names, ofFilesInMessagesAreThoseThatWereGiven) {
  const Program program;
  ASSERT_EQ(program.inFolder("mkdir a b").status, 0);
  for (const char* const line :
       {"synth shells --dims 24,20,16 -o a/v.nrrd", "synth shells --dims 20,20,16 -o b/v.nrrd",
        "pack a/v.nrrd -o a/v.zarr -q --levels 1 --chunk 4"})
    ASSERT_EQ(program.run(line).status, 0);
  const std::string raw = "a/v_24x20x16_uint8.raw";
  ASSERT_EQ(program.run("synth shells --dims 24,20,16 -o " + raw).status, 0);
  const auto errorOf = [&](const std::string& rest) {
    const CommandResult result = program.run("render " + rest + " --size 16 -o p.png --force");
    EXPECT_EQ(result.status, 1) << rest;
    return result.output;
  };
  EXPECT_THAT(errorOf("a/v.nrrd --level 5"), HasSubstr("sluice: a/v.nrrd: --level 5"));
  EXPECT_THAT(errorOf("a/v.zarr --level 1 --mode mip"),
              HasSubstr("sluice: a/v.zarr: its coarser levels hold"));
  EXPECT_THAT(errorOf(raw + " --spacing 1,1,1e12"), HasSubstr("sluice: " + raw + ": its spacing"));
  EXPECT_THAT(errorOf(raw + " --step 1e-9"), HasSubstr("sluice: " + raw + ": --step"));
  EXPECT_THAT(errorOf("b/v.nrrd --memory 100"), HasSubstr("sluice: b/v.nrrd: "));
  EXPECT_THAT(errorOf("a/v.nrrd --over b/v.nrrd --combine blend"),
              HasSubstr("b/v.nrrd is on another grid of voxels than a/v.nrrd"));
}

// People paste printed options: the shell must read the same names back.
TEST(Names, ofThePrintedLookAreReadBackByTheShell) {
  if (!haveProgram("bash")) GTEST_SKIP() << "no bash";
  const Program program;
  writeFile(program.folder / (kEvil + "look.json"),
            R"({"sluice_transfer_function": 1, "map": "grey", "opacities": [[90, 0.1]]})");
  const std::string render = std::string("render ") + kSmall + " --size 16 -o ";
  const CommandResult first = program.run(render + "a.png --transfer " + quoted("look.json"));
  ASSERT_EQ(first.status, 0) << first.output;
  const size_t at = first.output.find("look: ");
  ASSERT_NE(at, std::string::npos);
  const std::string options = first.output.substr(at + 6, first.output.find('\n', at) - at - 6);
  EXPECT_THAT(options, HasSubstr("--transfer $'"));
  const CommandResult again =
      runCommand("cd " + shellQuoted(program.folder.path().string()) + " && bash -c " +
                 shellQuoted(std::string(SLUICE_PROGRAM) + " " + render + "b.png " + options));
  EXPECT_EQ(again.status, 0) << again.output;
  EXPECT_TRUE(readFile(program.folder / "a.png") == readFile(program.folder / "b.png"));
  EXPECT_FALSE(program.exists("pwned"));
}

}  // namespace
}  // namespace sluice
