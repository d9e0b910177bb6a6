// Commands that a signal ends, and files that the system refuses: nothing half-written appears
// under a name that was asked for, and no temporary file stays.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Files and folders below the program's own folder that are temporary, by their names.
std::vector<std::string> temporaries(const Program& program) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(program.folder.path()))
    if (entry.path().extension() == ".tmp") found.push_back(entry.path().string());
  return found;
}

struct SignalCase {
  const char* command;
  const char* target;  // must not appear
  const char* until;   // when the signal is sent, a test of sh
};

// It has worked for 0.3 s of the processor's time: well past its start.
constexpr const char* kAtWork = "[ \"$(cut -d' ' -f14 /proc/$pid/stat)\" -ge 30 ]";

// Includes work that no loop of ours can interrupt: a chunk of 64 MiB inside Blosc, a plan of
// hundreds of thousands of chunks.
const SignalCase kCases[] = {
    {"synth noise -o big.raw --dims 2000,2000,2000", "big.raw", "[ -e big.raw.0.tmp ]"},
    {"synth noise -o big.nrrd --dims 2000,2000,2000", "big.nrrd", "[ -e big.nrrd.0.tmp ]"},
    {"pack synth:noise,dims=400x400x400 -o v.zarr --chunk 512 --codec zstd --level 9 --threads 1",
     "v.zarr", "[ -d v.zarr.partial ]"},
    {"info synth:noise,dims=1500x1500x1500", "none", kAtWork},
    {"plan synth:noise,dims=300x300x300 --page 4x4x4 --partition boxes", "none", kAtWork},
    {"simulate synth:noise,dims=200x200x200 --frames 200 --page 4x4x4 --csv t.csv --report t.json",
     "t.csv", kAtWork},
    {"prepare synth:mixing,dims=160x160x160,steps=64", "none", kAtWork},
    {"render synth:phantom,dims=64x64x64 --size 3000 -o a.exr", "a.exr", "[ -e a.exr.0.tmp ]"},
    {"render synth:phantom,dims=64x64x64 --size 3000 -o a.png", "a.png", "[ -e a.png.0.tmp ]"},
    {"render synth:phantom,dims=64x64x64 --size 5000 --device cpu --occlusion cull -o a.png",
     "a.png", kAtWork},
    {"render synth:noise,dims=100x100x100 --frames 300 --trace t.trace -o f_###.png", "t.trace",
     "[ -e f_001.png ]"},
    {"bench render synth:noise,dims=100x100x100 --frames 9999 --report r.json", "r.json", kAtWork},
};

class Signals : public testing::TestWithParam<SignalCase> {};

TEST_P(Signals, endACommandWithItsStatusAndNoFileHalfWritten) {
  const auto& [command, target, until] = GetParam();
  for (const auto& [signal, status] : {std::pair("INT", 130), {"TERM", 143}, {"KILL", 137}}) {
    SCOPED_TRACE(signal);
    const Program program;
    const CommandResult result = program.signalled(command, signal, until);
    if (result.status == 0) continue;  // it ended before the signal came
    EXPECT_EQ(result.status, status) << result.output;
    EXPECT_FALSE(program.exists(target));
    if (status == 137) continue;  // the next run takes over what a killed run leaves
    EXPECT_THAT(result.output, testing::HasSubstr("sluice: interrupted"));
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    EXPECT_THAT(temporaries(program), testing::IsEmpty());
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, Signals, testing::ValuesIn(kCases));

// `ulimit -f`: a write beyond it fails, and is no signal that ends the process.
TEST(FileLimit, isALineForEveryWriterAndNoTemporaryStays) {
  const Program program;
  fs::create_symlink("/dev/null", program.folder / "null.png");  // has no limit
  const std::string render = "render synth:noise,dims=64x64x64 -q --page 8x8x8 --block 16 ";
  const std::string drawn = render + "--size 16 -o null.png ";
  for (const std::string& line :
       {drawn + "--trace a.trace", std::string("bench slicing --report r.json"),
        std::string("bench slicing --report s.json")})
    ASSERT_EQ(program.run(line).status, 0) << line;
  for (const std::string& line :
       {render + "-o b.png", render + "-o b.exr", drawn + "--report b.json",
        drawn + "--trace b.txt", drawn + "--trace b.csv", drawn + "--trace b.oracleGeneral",
        drawn + "--trace b.trace", std::string("simulate a.trace --csv b.csv"),
        std::string("simulate a.trace --html b.html"),
        std::string("simulate a.trace --report b.json"),
        std::string("simulate a.trace --export b.din"),
        std::string("synth noise --dims 64,64,64 -o b.raw"),
        std::string("synth noise --dims 64,64,64 -o b.mhd"),
        std::string("pack synth:noise,dims=64x64x64 -o b.zarr"),
        std::string("bench report r.json s.json -o b.html")}) {
    // Limits files to one block of 512 bytes. No index is written, because its failure is only a
    // warning.
    const CommandResult result =
        runCommand("cd " + shellQuoted(program.folder.path().string()) +
                   " && ulimit -f 1 && SLUICE_INDEX=off " SLUICE_PROGRAM " " + line);
    EXPECT_EQ(result.status, 1) << line << ": " << result.output;
    EXPECT_THAT(result.output, testing::HasSubstr("File too large")) << line;
    // But for the warning that no index is kept.
    const auto lines = std::count(result.output.begin(), result.output.end(), '\n');
    EXPECT_LE(lines, result.output.find("index is disabled") == std::string::npos ? 1 : 2)
        << result.output;
    EXPECT_THAT(temporaries(program), testing::IsEmpty()) << line;
    for (const auto& entry : fs::directory_iterator(program.folder.path()))
      EXPECT_NE(entry.path().stem(), "b") << line;
  }
}

}  // namespace
}  // namespace sluice
