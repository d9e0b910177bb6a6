// --over: two volumes in one picture, each at its place in the world. NumPy writes the same spot
// on grids, in axes and in units that differ, so that the pictures must not.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/program.h"
#include "tests/tools/script_files.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Over : public testing::Test {
 protected:
  void SetUp() override {
    if (!copyScriptFiles("over.py", "numpy, PIL", program_.folder.path()))
      GTEST_SKIP() << "python3 with numpy and pil is missing";
  }
  std::string python(const std::string& arguments) const {
    return program_.inFolder("/usr/bin/python3 " SLUICE_TEST_DIR "/tools/over.py " + arguments)
        .output;
  }
  // The largest difference of two pictures that show something, or of one and the sum of others.
  int difference(const std::string& first, const std::string& second,
                 const std::string& third = "") const {
    const std::vector<int> all = differences(first + " " + second + " " + third);
    return all.size() == 1 ? all[0] : -1;
  }
  // The same of several such lists with / between them, by one start of Python.
  std::vector<int> differences(const std::string& lists) const {
    std::istringstream lines(python("compare " + lists));
    std::vector<int> all;
    for (int most = 0, brightest = 0; lines >> most >> brightest;) {
      EXPECT_GT(brightest, 60) << lists;
      all.push_back(most);
    }
    EXPECT_FALSE(all.empty()) << lists;
    return all;
  }
  std::string render(const std::string& arguments) const {
    const CommandResult result =
        program_.run("render --force --size 160x140 --background 000000 " + arguments);
    EXPECT_EQ(result.status, 0) << arguments << "\n" << result.output;
    return result.output;
  }

  const Program program_;
};

constexpr const char* kSide = " --view front --azimuth 30 --elevation 20";

TEST_F(Over, gridAxesAndUnitsOfTheSecondVolumeMakeNoDifference) {
  // A crop and planes have other places on the second volume's grid, depths another unit.
  const std::string side = kSide;
  std::vector<std::string> ways;
  std::string lists;
  for (const std::string& options :
       {side, side + " --projection perspective", side + " --fit volume --zoom 1.7",
        side + " --crop 5,5,15,40,30,35",
        side + " --crop 5,5,15,40,30,35 --clip 1,0.2,0,90 --clip 0,0,-1,-40",
        side + " --depth-cueing", side + " --mode mip", side + " --mode depth-mip",
        side + " --step 0.3", std::string("--eye 60,-200,80 --target 60,30,60 --zoom 2"),
        std::string("--eye 60,-200,80 --target 60,30,60 --projection perspective")}) {
    SCOPED_TRACE(options);
    const std::string n = std::to_string(ways.size());
    ways.push_back(options);
    for (const char* over : {"spot", "turned", "silent"})
      render(fmt::format("scan.nrrd --over {0}.nrrd --combine add -o {0}{1}.png {2}", over, n,
                         options));
    render(fmt::format("scan.nrrd -o alone{}.png {}", n, options));
    lists += fmt::format(
        "{1} spot{0}.png turned{0}.png / spot{0}.png silent{0}.png / spot{0}.png alone{0}.png", n,
        lists.empty() ? "" : " /");
  }
  const std::vector<int> most = differences(lists);
  ASSERT_EQ(most.size(), 3 * ways.size());
  for (size_t i = 0; i < ways.size(); ++i) {
    EXPECT_LE(most[3 * i], 1) << "turned, " << ways[i];
    EXPECT_LE(most[3 * i + 1], 1) << "silent, " << ways[i];
    EXPECT_GT(most[3 * i + 2], 20) << ways[i];
  }
}

TEST_F(Over, isTheSumOfBothOnEachDevice) {
  const std::string scan = "scan.nrrd --map plaster --range 0,255 --opacities 10:0,255:0.1";
  for (const char* device : {"--device cpu", "--device gl --gl osmesa"}) {
    const std::string common =
        fmt::format(" {} {} --fit volume --step 0.5 --no-shade -o ", device, kSide);
    if (program_.run("render spot.nrrd --size 9x9 --force " + common + "try.png").status != 0)
      GTEST_SKIP() << "no software OpenGL";
    EXPECT_THAT(render(scan + " --over turned.nrrd --look over:green,20:200,0.3 --verify" + common +
                       "both.png"),
                HasSubstr("0 pixels above 1/255"));
    render(scan + common + "scan.png");
    render("spot.nrrd --map green --range 20,200 --opacities 20:0,200:0.3" + common + "spot.png");
    // Each of the pictures is rounded.
    EXPECT_LE(difference("both.png", "scan.png", "spot.png"), 2) << device;
  }
}

// The scan is lit, and the labels have another type of voxel.
TEST_F(Over, isBlendedOnOneGrid) {
  const std::string command = "scan.nrrd --over labels.nrrd --combine blend -o blend.png --verify ";
  for (const char* options : {"", "--look over:labels,0.3", "--projection perspective",
                              "--block 16 --page 16x16x16", "--step 0.7"})
    EXPECT_THAT(render(command + options), HasSubstr("0 pixels above 1/255")) << options;
  render("scan.nrrd --over moved.nrrd --combine blend --step 0.7 -o moved.png");
  EXPECT_LE(difference("blend.png", "moved.png"), 1);
  render("scan.nrrd --over labels.nrrd --combine add -o add.png");
  EXPECT_GT(difference("blend.png", "add.png"), 20);
  const CommandResult result =
      program_.run("render scan.nrrd --over turned.nrrd --combine blend -o no.png");
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.output, HasSubstr("turned.nrrd is on another grid of voxels than scan.nrrd"));
}

// Added, labels and the scan under them are nearly white together.
TEST_F(Over, isOneMediumOnOneGridUnlessAsked) {
  const auto isAs = [&](const char* combine, const std::string& arguments) {
    SCOPED_TRACE(arguments);
    const std::string command = "scan.nrrd " + arguments;
    EXPECT_THAT(render(command + " --verify -o unasked.png"),
                AllOf(HasSubstr("0 pixels above 1/255"), Not(HasSubstr("--combine="))));
    render(command + " -o asked.png --combine " + combine);
    EXPECT_EQ(difference("unasked.png", "asked.png"), 0);
  };
  const std::string labels = "--over labels.nrrd ";
  for (const char* options : {"", "--look over:labels,0.3", "--shade --step 0.7", "--level 0"})
    isAs("blend", labels + options);
  isAs("blend", "--over moved.nrrd");
  isAs("add", "--over turned.nrrd");
  for (const char* options : {"--mode mip", "--iso 100 --threshold 60", "--shade --shadows",
                              "--occlusion clip --opacity-threshold 1", "--partition boxes"})
    isAs("add", labels + options);
  const std::string note = "warning: the pictures of the two volumes are added, not blended: ";
  for (const char* options : {"--partition boxes", "--iso 100 --threshold 60"})
    for (const char* command : {"render --force -o note.png ", "plan ", "simulate "})
      EXPECT_THAT(program_.run(command + ("scan.nrrd " + labels) + options).output,
                  HasSubstr(note + "--combine blend draws "))
          << command << options;
  EXPECT_THAT(
      program_.json("render scan.nrrd " + labels + "--iso 100 -q --force -o note.png")["warnings"],
      testing::Contains(HasSubstr("are added, not blended: ")));
  EXPECT_THAT(render("scan.nrrd " + labels + "--partition boxes --combine add -o note.png"),
              Not(HasSubstr(note)));
  EXPECT_THAT(render("scan.nrrd --over turned.nrrd --partition boxes -o note.png"),
              Not(HasSubstr(note)));
  EXPECT_THAT(render("scan.nrrd " + labels + "--quality high -o high.png"),
              HasSubstr("--quality changes nothing in a blended picture"));
  EXPECT_THAT(render("scan.nrrd " + labels + "--combine add -o add.png"),
              HasSubstr("--combine=add"));
  EXPECT_GT(difference("high.png", "add.png"), 20);
  render("scan.nrrd " + labels + "--look over:labels,0.1 -o haze.png");
  EXPECT_EQ(difference("high.png", "haze.png"), 0);
}

// Blocks of 8 and of 16 bits have different sizes unless they are blended.
TEST_F(Over, isOneMediumWithAVolumeOfAnotherType) {
  for (const char* volumes : {"scan16.nrrd --over labels.nrrd", "labels.nrrd --over scan16.nrrd"}) {
    SCOPED_TRACE(volumes);
    EXPECT_THAT(render(std::string(volumes) + " --verify -o unasked.png"),
                AllOf(HasSubstr("0 pixels above 1/255"), Not(HasSubstr("added, not blended"))));
    render(std::string(volumes) + " -o asked.png --combine blend");
    EXPECT_EQ(difference("unasked.png", "asked.png"), 0);
    const auto plan = program_.json(std::string("plan ") + volumes)["channels"];
    const auto blocksOf = [&](size_t channel) {
      int count = 0;
      for (const auto& blocks : plan[channel]["blocks"]) count += blocks.get<int>();
      return count;
    };
    EXPECT_EQ(blocksOf(0), blocksOf(1));
  }
}

// The plan, the report and the simulator have the blocks of the blended picture.
TEST_F(Over, isPlannedAsItIsDrawn) {
  for (const char* combine : {"", "--combine blend ", "--combine add "}) {
    SCOPED_TRACE(combine);
    const std::string options = std::string("scan.nrrd --over labels.nrrd --size 160x140 ") +
                                "--block 16 --page 16x16x16 --pages 64 " + combine;
    const auto plan = program_.json("plan " + options)["channels"];
    const auto frame = program_.json("render " + options + "--force -o a.png")["frames"][0];
    const auto simulated = program_.json("simulate " + options + "--frames 1 --policies lru");
    for (size_t c = 0; c < 2; ++c) {
      const auto& drawn = frame["channels"][c];
      EXPECT_GT(drawn["chunks"], 0);
      EXPECT_EQ(plan[c]["blocks"], drawn["blocks"]);
      EXPECT_EQ(plan[c]["algorithms"]["merged"]["chunks"], drawn["chunks"]);
      for (const auto& row : simulated["rows"])
        if (row["channel"] == drawn["channel"] && row["pages"] == 64) {
          EXPECT_EQ(row["chunk_requests"], drawn["chunks"]);
        }
    }
  }
}

TEST_F(Over, labelsHaveTheirColours) {
  // Automatically, by a look, and by a table.
  const std::string common = "spot.nrrd --opacities 250:0,255:0 --over labels.nrrd --view left ";
  EXPECT_THAT(render(common + "-o found.png"), HasSubstr("--look=over:"));
  render(common + "--look over:labels -o asked.png");
  EXPECT_LE(difference("found.png", "asked.png"), 0);
  render(common + "--look over:table.txt,1 -o table.png");
  EXPECT_EQ(python("hues table.png"), "3\n");
  EXPECT_EQ(python("hues asked.png"), "0\n");
}

// Other modes mix the numbers of labels, so that colours would show that are nobody's.
TEST_F(Over, labelsNeedAModeOfColours) {
  std::ofstream(program_.folder.path() / "one.txt") << "1 255 0 0 1 1 1 \"one\"\n";
  for (const char* mode : {"mip", "minip", "average", "attenuated-mip", "depth-mip"})
    for (const char* look : {"over:labels", "over:labels,0.3", "over:one.txt", "0:labels"}) {
      SCOPED_TRACE(std::string(mode) + " " + look);
      for (const char* command : {"render -o no.png", "plan", "simulate"}) {
        const CommandResult result = program_.run(fmt::format(
            "{} scan.nrrd --over labels.nrrd --mode {} --look {}", command, mode, look));
        EXPECT_EQ(result.status, 2);
        EXPECT_EQ(result.output, fmt::format("sluice: --look {} needs --mode composite, since "
                                             "other modes mix the numbers of labels\n",
                                             look));
      }
    }
  // Unasked, they are values there.
  const std::string common = "scan.nrrd --over labels.nrrd --mode mip -o ";
  render(common + "unasked.png");
  render(common + "hot.png --look over:hot");
  EXPECT_EQ(difference("unasked.png", "hot.png"), 0);
}

TEST_F(Over, labelsThatATableHidesStayHidden) {
  const auto write = [&](const char* name, const char* seven) {
    std::ofstream(program_.folder.path() / name)
        << "1 255 0 0 1 1 1 \"one\"\n2 0 255 0 1 1 1 \"two\"\n"
        << seven;
  };
  write("hidden.txt", "7 0 0 255 1 0 1 \"seven\"\n");
  write("without.txt", "");
  const std::string common =
      "spot.nrrd --opacities 250:0,255:0 --over labels.nrrd --view left --annotate --look over:";
  for (const char* opacity : {",1", ",0.2", ""}) {
    SCOPED_TRACE(opacity);
    render(fmt::format("{}hidden.txt{} -o hidden.png", common, opacity));
    render(fmt::format("{}without.txt{} -o without.png", common, opacity));
    render(fmt::format("{}table.txt{} -o table.png", common, opacity));
    EXPECT_EQ(difference("hidden.png", "without.png"), 0);
    EXPECT_GT(difference("hidden.png", "table.png"), 20);
  }
  // Without an opacity, the table's own count.
  render(common + "table.txt -o own.png");
  render(common + "table.txt,1 -o one.png");
  EXPECT_EQ(difference("own.png", "one.png"), 0);
}

TEST_F(Over, saysWhatDoesNotFit) {
  EXPECT_THAT(render("scan.nrrd --over apart.nrrd -o apart.png"),
              HasSubstr("apart.nrrd: lies beside scan.nrrd in the world"));
  std::ofstream(program_.folder.path() / "a.json") << "1 one 255 0 0 255\n";
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c : {Case{"--over missing.nrrd", "missing.nrrd: "},
                        Case{"--over steps.nrrd",
                             "steps.nrrd: 2 time steps, and scan.nrrd has 1: a volume over "
                             "another one has as many, or one"},
                        Case{"--over spot.nrrd --debug-view --occlusion map",
                             "--debug-view shows one channel, not 2; leave out --over"},
                        Case{"--look over:green", "--look over:green: that channel is not shown"},
                        Case{"--over spot.nrrd --look over:nocolour", "nocolour"},
                        Case{"--over labels.nrrd --look over:./a.json --report a.json --force",
                             "a.json, which this command reads"},
                        Case{"--over spot.nrrd --look over:none.txt", "none.txt"}}) {
    const CommandResult result =
        program_.run(std::string("render scan.nrrd -o no.png ") + c.arguments);
    EXPECT_EQ(result.status, 1) << c.arguments;
    EXPECT_THAT(result.output, HasSubstr(c.message)) << c.arguments;
  }
  EXPECT_FALSE(std::filesystem::exists(program_.folder.path() / "no.png"));
}

TEST_F(Over, asksForNoOptionOfTheFirstVolumeForARawOne) {
  const auto write = [&](const char* name) {
    std::ofstream(program_.folder.path() / name) << std::string(512, 'a');
  };
  for (const char* name : {"w.raw", "w_8x8x8.raw", "w_8x8x9_uint8.raw", "w_8x8x8_uint8.raw"})
    write(name);
  const std::string described = "--dims 8,8,8 --type u8 ";
  const std::string in_name =
      "--dims, --type and --skip describe the first volume; put size and type into the name of "
      "this one, such as head_256x256x225_uint8.raw, or give it a header\n";
  for (const auto& [over, problem] : std::map<std::string, std::string>{
           {"w.raw", "dimensions unknown; "},
           {"w_8x8x8.raw", "voxel type unknown; "},
           {"w_8x8x9_uint8.raw",
            "8 x 8 x 9 x 1 byte (u8) + 0 skipped = 576 bytes expected, 512 found; "}})
    EXPECT_EQ(program_.run("render w.raw " + described + "-o no.png --over " + over).output,
              "sluice: " + over + ": " + problem + in_name);
  EXPECT_THAT(program_.run("render scan.nrrd " + described + "-o no.png --over w.raw").output,
              HasSubstr("scan.nrrd: the file contains its size and type; leave out --dims, --type, "
                        "--endian and --skip, which are for raw files and describe the first "
                        "volume; a raw file of --over is described by its name"));
  EXPECT_EQ(program_.run("render w.raw " + described + "-o w.png --over w_8x8x8_uint8.raw").status,
            0);
}

TEST_F(Over, saysIfLengthsHaveNoUnitInCommon) {
  const std::string said =
      "bare.nrrd has no unit of length, and micro.nrrd has the unit micrometer";
  EXPECT_THAT(render("micro.nrrd --over bare.nrrd -o bare.png --report bare.json"),
              HasSubstr("warning: " + said));
  const CommandResult report =
      runCommand("/usr/bin/python3 -c 'import json; print(*json.load(open(\"" +
                 (program_.folder.path() / "bare.json").string() + "\"))[\"warnings\"])'");
  EXPECT_THAT(report.output, HasSubstr(said));
  // Millimeters are usual, known units are converted, and a copy of the numbers is no other place.
  for (const char* fitting : {"scan.nrrd --over bare.nrrd", "scan.nrrd --over turned.nrrd",
                              "micro.nrrd --over copied.nrrd"})
    EXPECT_THAT(render(std::string(fitting) + " -o fits.png"), Not(HasSubstr("warning")))
        << fitting;
}

TEST_F(Over, aStillVolumeIsShownInEachStepOfASeries) {
  render("steps.nrrd --over scan.nrrd --time 0:1 -o step%02d.png --fit volume");
  EXPECT_LE(difference("step00.png", "step01.png"), 0);
}

TEST_F(Over, planAndReportCountBoth) {
  render("scan.nrrd --over turned.nrrd -o both.png --report both.json");
  const CommandResult plan = program_.run("plan scan.nrrd --over turned.nrrd --size 160x140");
  EXPECT_EQ(plan.status, 0) << plan.output;
  EXPECT_THAT(plan.output, HasSubstr("the volume over it (turned.nrrd)"));
  const CommandResult report = runCommand(
      "/usr/bin/python3 -c 'import json; print([c[\"channel\"] for c in json.load(open(\"" +
      (program_.folder.path() / "both.json").string() + "\"))[\"channels\"]])'");
  EXPECT_EQ(report.output, "[0, 'over']\n");
}

}  // namespace
}  // namespace sluice
