// Ranks that were started with different commands or read different data: every rank ends with
// status 1, one line names the rank and the difference, and no picture is written.
#include "tests/parallel/ranks_program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

class RanksAgreement : public RanksTest {
 protected:
  CommandResult onTwo(const std::string& first, const std::string& second) const {
    return runCommand("cd " + shellQuoted(program_.folder.path().string()) +
                      "; export XDG_CACHE_HOME=\"$PWD/cache\"; " +
                      GetParam().startEach({first, second}));
  }
  void expectRefused(const std::string& first, const std::string& second,
                     const std::string& reason) const {
    SCOPED_TRACE(first + " : " + second);
    const CommandResult run = onTwo(first, second);
    EXPECT_EQ(run.status, 1) << run.output;
    EXPECT_EQ(occurrences(run.output, "sluice: "), 1) << run.output;
    EXPECT_THAT(run.output, HasSubstr("sluice: rank 1 of 2"));
    EXPECT_THAT(run.output, HasSubstr(reason));
    EXPECT_FALSE(program_.exists("a.png"));
  }
  const Program program_;
};

constexpr const char* kRender = "render synth:shells,dims=40x40x40 -o a.png --size 50 ";

TEST_P(RanksAgreement, isAboutOptionsThatSayWhatIsDrawn) {
  const std::string render = kRender;
  expectRefused(render + "--block 16", render + "--block 32", "--block is 32, on rank 0 16");
  expectRefused(render + "--threshold 40", render + "--threshold 90",
                "--threshold is 90, on rank 0 40");
  expectRefused(render, render + "--mode mip", "--mode is mip, on rank 0");
  expectRefused("render synth:shells,dims=40x40x40 -o a_%d.png --size 50 --frames 2",
                "render synth:shells,dims=40x40x40 -o a_%d.png --size 50 --frames 3",
                "--frames is 3, on rank 0 2");
  expectRefused(render, render + "--json", "--json is true, on rank 0 not given");
  expectRefused(render, "bench ranks synth:shells,dims=40x40x40 --size 50",
                "the command is ranks, on rank 0 render");
}

TEST_P(RanksAgreement, isNotAboutARanksOwnMachine) {
  const std::string render = kRender;
  const CommandResult run = onTwo(render + "--memory 200M -j 1", render + "--memory 300M -j 2 -q");
  EXPECT_EQ(run.status, 0) << run.output;
  EXPECT_TRUE(program_.exists("a.png"));
}

TEST_P(RanksAgreement, endsAllWhenOneIsRefused) {
  const std::string render = kRender;
  expectRefused(render, render + "--blocks 16", "--blocks");
  expectRefused(render, "info synth:shells", "info on one");
}

TEST_P(RanksAgreement, isAboutTheVolumesVoxels) {
  for (const char* folder : {"a", "b", "c"})
    std::filesystem::create_directory(program_.folder / folder);
  ASSERT_EQ(program_.run("synth shells -o a/v.nrrd --dims 40,40,40 -q").status, 0);
  ASSERT_EQ(program_.run("synth sparse -o b/v.nrrd --dims 40,40,40 -q").status, 0);
  ASSERT_EQ(program_.run("synth shells -o c/v.nrrd --dims 40,40,38 -q").status, 0);
  const std::string rest = "/v.nrrd -o a.png --size 50";
  expectRefused("render a" + rest, "render b" + rest, "voxels differ");
  expectRefused("render a" + rest, "render c" + rest,
                "the volume's size is 40 x 40 x 38, on rank 0 40 x 40 x 40");
  expectRefused("render a" + rest, "render b" + rest, "is b/v.nrrd an old copy on one host?");
  const CommandResult same = onTwo("render a" + rest, "render ./a" + rest);
  EXPECT_EQ(same.status, 0) << same.output;
}

TEST_P(RanksAgreement, isAboutEachStepOfASeries) {
  for (const char* folder : {"a", "b"}) {
    std::filesystem::create_directory(program_.folder / folder);
    ASSERT_EQ(
        program_
            .run(fmt::format("synth mixing -o {}/v_%d.nrrd --dims 32,32,32 --steps 3 -q", folder))
            .status,
        0);
  }
  std::filesystem::copy_file(program_.folder / "b/v_1.nrrd", program_.folder / "b/v_2.nrrd",
                             std::filesystem::copy_options::overwrite_existing);
  const std::string rest =
      "/v_%d.nrrd --time 0:2 --map grey --range 0,255 --opacities 0:0,255:1 --size 40 -o a_%d.png "
      "--fit volume";
  expectRefused("render a" + rest, "render b" + rest, "time step 2 of b/v_%d.nrrd");
}

TEST_P(RanksAgreement, isAboutWhatTransferFunctionsAndPathsHold) {
  const auto transfer = [&](const char* name, double opacity) {
    writeFile(
        program_.folder / name,
        fmt::format(
            R"({{"sluice_transfer_function": 1, "colors": [[0, "#ffffff"]], "opacities": [[0, 0], [255, {}]]}})",
            opacity));
  };
  transfer("one.json", 0.5);
  transfer("two.json", 0.4);
  const std::string render = kRender;
  expectRefused(render + "--transfer one.json", render + "--transfer two.json",
                "transfer functions differ");
}

// A receive that was given up neither takes the next message nor is written to.
TEST_P(RanksAgreement, messagesOfARankThatStopsWaitingDoNoHarm) {
  for (const char* way : {"waiting", "arriving"}) {
    const CommandResult run =
        runCommand(GetParam().startProgram(INTERRUPTED_RANKS, 2, 60) + " " + way);
    EXPECT_EQ(run.status, 0) << way << ": " << run.output;
  }
}

INSTANTIATE_TEST_SUITE_P(By, RanksAgreement, testing::Values(kOpenMpiLauncher, kMpichLauncher),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace sluice
