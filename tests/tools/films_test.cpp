// Several pictures in one run: films by ffmpeg, camera paths along a series, and series that go on
// after an interruption.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSeries = "synth:mixing,dims=24x24x24,steps=4";

// A program called ffmpeg that keeps its arguments and writes its input, behind a mark that makes
// it a film of ours.
class FakeFfmpeg {
 public:
  explicit FakeFfmpeg(const Program& program, const std::string& body = kWrites) {
    fs::create_directory(program.folder / "bin");
    writeFile(program.folder / "bin" / "ffmpeg", "#!/bin/sh\n" + body);
    fs::permissions(program.folder / "bin" / "ffmpeg", fs::perms::owner_all);
  }
  static constexpr const char* kWrites =
      "printf '%s\\n' \"$@\" > words\n"
      "for last; do :; done\n"
      "{ printf '\\0\\0\\0\\040ftypisom'; for word; do case $word in comment=*) echo "
      "\"${word#comment=}\";; esac; done; cat; } > \"${last#file:}\"\n";
};

CommandResult film(const Program& program, const std::string& arguments) {
  return runCommand(
      "cd " + shellQuoted(program.folder.path().string()) +
      " && PATH=\"$PWD/bin:$PATH\" XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM " " + arguments);
}

TEST(Films, areFedToFfmpegFrameByFrame) {
  const Program program;
  const FakeFfmpeg ffmpeg(program);
  const std::string render =
      std::string("render ") + kSmall + " --frames 3 --size 22x14 --background 204060 ";
  const CommandResult made = film(program, render + "-o turn.mp4 --rate 12.5");
  ASSERT_EQ(made.status, 0) << made.output;
  ASSERT_EQ(film(program, render + "-o f_%d.png -q").status, 0);
  std::string expected;
  for (int i = 0; i < 3; ++i) {
    const Rgba8Picture frame = readPng(program.folder / fmt::format("f_{}.png", i));
    for (size_t p = 0; p < frame.rgba.size(); ++p)
      if (p % 4 != 3) expected += static_cast<char>(frame.rgba[p]);
  }
  const std::string bytes = readFile(program.folder / "turn.mp4");
  EXPECT_TRUE(bytes.ends_with("\n" + expected)) << bytes.size() << " for " << expected.size();
  const std::string words = readFile(program.folder / "words");
  EXPECT_THAT(words, HasSubstr("\n22x14\n"));
  EXPECT_THAT(words, HasSubstr("-framerate\n12.5\n"));
  // A film of ours is replaced, and nothing else.
  EXPECT_EQ(film(program, render + "-o turn.mp4 -q").status, 0);
  writeFile(program.folder / "holiday.mp4", std::string("\0\0\0 ftypisom, not ours", 22));
  const CommandResult refused = film(program, render + "-o holiday.mp4");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output,
              HasSubstr("holiday.mp4: exists and is not a film of sluice; --force"));
}

TEST(Films, ofASavedViewGoAlongItsPath) {
  const Program program;
  const FakeFfmpeg ffmpeg(program);
  writeFile(program.folder / "v.json",
            std::string(R"({"sluice": "view", "volume": {"paths": [")") + kSmall +
                R"("]}, "path": {"kind": "turn", "frames": 3, "rate": 8}})");
  ASSERT_EQ(film(program, "render --state v.json --size 16 -o a.mp4 -q").status, 0);
  EXPECT_THAT(readFile(program.folder / "words"), HasSubstr("-framerate\n8\n"));
  const std::string bytes = readFile(program.folder / "a.mp4");
  EXPECT_EQ(bytes.size() - bytes.find('\n') - 1, 3U * 16 * 16 * 3);
}

TEST(Films, sayInALineWhatIsMissing) {
  const Program program;
  const std::string render = std::string("render ") + kSmall + " --size 16 -o a.mp4 ";
  const CommandResult none =
      runCommand("cd " + shellQuoted(program.folder.path().string()) +
                 " && PATH=/nowhere XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM " " + render +
                 "--frames 2");
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.output, HasSubstr("a.mp4: films are made by ffmpeg, which is not on the PATH"));
  const FakeFfmpeg broken(program, "cat > /dev/null; echo no such encoder >&2; exit 1\n");
  const CommandResult failed = film(program, render + "--frames 2");
  EXPECT_EQ(failed.status, 1);
  EXPECT_THAT(failed.output, HasSubstr("a.mp4: ffmpeg failed: no such encoder"));
  // The real one does so if the disk is full when it closes the file.
  const FakeFfmpeg full(
      program, std::string(FakeFfmpeg::kWrites) + "echo No space left >&2; echo closing >&2\n");
  const CommandResult cut = film(program, render + "--frames 2");
  EXPECT_EQ(cut.status, 1);
  EXPECT_THAT(cut.output, HasSubstr("a.mp4: ffmpeg failed: No space left; closing\n"));
  const FakeFfmpeg silent(program, "cat > /dev/null; exit 3\n");
  EXPECT_THAT(film(program, render + "--frames 2").output, HasSubstr("it ended with status 3"));
  const FakeFfmpeg killed(program, "kill -9 $$\n");
  EXPECT_THAT(film(program, render + "--frames 2").output, HasSubstr("it was ended by signal 9"));
  const FakeFfmpeg deaf(program, "exec <&-; echo out of memory >&2; exit 1\n");
  EXPECT_THAT(
      film(program, std::string("render ") + kSmall + " --size 200 -o a.mp4 --frames 40").output,
      HasSubstr("out of memory"));
  EXPECT_THAT(film(program, render).output, HasSubstr("a film has several frames"));
  EXPECT_THAT(film(program, render + "--frames 2 --continue").output, HasSubstr("in one go"));
  for (const auto& entry : fs::directory_iterator(program.folder.path()))
    EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".mp4"))) << "left behind";
}

// The frames of real ffmpeg, counted by its own tool.
TEST(Films, haveTheirFramesByFfmpegItself) {
  if (!haveProgram("ffmpeg") || !haveProgram("ffprobe")) GTEST_SKIP() << "no ffmpeg here";
  const Program program;
  const CommandResult drawn =
      program.run(std::string("render ") + kSmall + " --size 63x41 --frames 7 -o a.mp4");
  ASSERT_EQ(drawn.status, 0);
  EXPECT_THAT(drawn.output, testing::HasSubstr("a.mp4: the film has 64 x 42 pixels"));
  const CommandResult probed = runCommand(
      "ffprobe -v error -count_frames -show_entries stream=nb_read_frames,width,height -of "
      "csv=p=0 " +
      shellQuoted((program.folder / "a.mp4").string()));
  EXPECT_EQ(probed.output, "64,42,7\n");
  EXPECT_EQ(
      program.run(std::string("render ") + kSmall + " --size 16 --frames 2 -o a.mp4 -q").status, 0)
      << "the mark is found";
}

// A camera that comes near takes smaller steps, as it does in a picture of its own.
TEST(Paths, haveTheStepOfEachCamera) {
  const Program program;
  writeFile(program.folder / "path.json", R"({"keys": [{"at": 0, "azimuth": 20, "zoom": 0.3},
    {"at": 1, "azimuth": 20, "zoom": 4}]})");
  const std::string render = std::string("render ") + kSmall + " --size 40 -q --no-shade ";
  ASSERT_EQ(program.run(render + "--path path.json --frames 2 -o f_%d.png").status, 0);
  ASSERT_EQ(program.run(render + "--azimuth 20 --zoom 4 -o near.png").status, 0);
  EXPECT_TRUE(readFile(program.folder / "near.png") == readFile(program.folder / "f_1.png"));
}

// A step with thin parts shows finer levels, and takes smaller steps.
TEST(Paths, keepThinPartsOfEachStepAsInAPictureOfItsOwn) {
  const Program program;
  constexpr size_t kSide = 96, kStep = kSide * kSide * kSide;
  std::string voxels(3 * kStep, '\0');
  const auto at = [&](size_t time, size_t x, size_t y, size_t z) -> char& {
    return voxels[time * kStep + (z * kSide + y) * kSide + x];
  };
  for (size_t time = 0; time < 3; ++time)
    for (size_t i = 0; i < 48 * 48 * 48; ++i)
      at(time, 40 + i % 48, 40 + i / 48 % 48, 40 + i / 48 / 48) = '\xff';
  for (size_t y = 0; y < kSide; ++y) at(1, 4, y, 4) = '\xff';
  writeFile(program.folder / "s.raw", voxels);
  ASSERT_EQ(program.run("pack s.raw --dims 96,96,96,3 --type u8 -o s.zarr --levels 3 -q").status,
            0);
  writeFile(program.folder / "path.json",
            R"({"keys": [{"at": 0, "azimuth": 0}, {"at": 1, "azimuth": 0}]})");
  const std::string render =
      "render s.zarr --threshold 80 --keep-thin --pixel-error 3 --size 96 --block 32 --view front "
      "--fit volume --no-shade --force -q ";
  for (const char* path : {"", "--path path.json "}) {
    ASSERT_EQ(program.run(render + path + "--time 0:2 -o f_%d.png").status, 0);
    for (const int time : {0, 1, 2}) {
      ASSERT_EQ(program.run(render + fmt::format("--time {} -o one.png", time)).status, 0);
      EXPECT_TRUE(readFile(program.folder / "one.png") ==
                  readFile(program.folder / fmt::format("f_{}.png", time)))
          << path << time;
    }
  }
}

// No picture is written before a camera that sees nothing is found.
TEST(Paths, nameTheFrameWhoseCameraIsNone) {
  const Program program;
  const std::string render = std::string("render ") + kSmall + " --size 16 -q -o f_%d.png ";
  const auto said = [&](const std::string& keys, const std::string& options) {
    writeFile(program.folder / "p.json", R"({"keys": [)" + keys + "]}");
    const CommandResult result = program.run(render + "--path p.json " + options);
    EXPECT_EQ(result.status, 1) << keys;
    EXPECT_FALSE(program.exists("f_0.png")) << keys;
    return result.output;
  };
  EXPECT_EQ(said(R"({"at": 0, "eye": [9, 9, -30], "target": [9, 9, 0]},
                    {"at": 1, "eye": [9, 9, 30], "target": [9, 9, 0]})",
                 "--frames 3"),
            "sluice: p.json: frame 1, at 0.5 of the path: the camera's eye lies on its target\n");
  EXPECT_EQ(said(R"({"at": 0, "up": [0, 1, 0]}, {"at": 1, "up": [0, -1, 0]})", "--frames 5"),
            "sluice: p.json: frame 2, at 0.5 of the path: the camera's up direction is 0, 0, 0: "
            "must have a length\n");
  EXPECT_THAT(said(R"({"at": 0, "eye": [9, 9, 30], "target": [9, 9, 0], "up": [0, 1, 0]},
                      {"at": 1, "up": [0, 0, 1]})",
                   "--frames 2"),
              HasSubstr("p.json: frame 1, at 1 of the path: the camera's up direction lies along"));
}

TEST(Paths, refuseAnglesBesidePositions) {
  const Program program;
  const std::string render =
      std::string("render ") + kSmall + " --size 16 -o f_%d.png --frames 2 --path p.json ";
  writeFile(program.folder / "p.json", R"({"keys": [
    {"at": 0, "eye": [0, 0, 90], "target": [9, 9, 9]}, {"at": 1, "azimuth": 9}]})");
  EXPECT_THAT(program.run(render).output,
              testing::StartsWith("sluice: p.json: key 1: \"azimuth\" has no effect beside"));
  writeFile(program.folder / "p.json", R"({"keys": [
    {"at": 0, "eye": [0, 0, 90], "target": [9, 9, 9]}, {"at": 1, "zoom": 2}]})");
  for (const std::string option : {"--azimuth 30", "--view top", "--fit volume"})
    EXPECT_EQ(program.run(render + option).output,
              "sluice: p.json: " + option.substr(0, option.find(' ')) +
                  " has no effect beside the keys' \"eye\" and \"target\"; leave it out\n");
  EXPECT_FALSE(program.exists("f_0.png"));
}

TEST(Paths, tellOfAFieldOfViewThatAnOrthographicCameraLacks) {
  const Program program;
  writeFile(program.folder / "p.json", R"({"keys": [{"at": 0, "fov": 20}, {"at": 1, "fov": 90}]})");
  const std::string render =
      std::string("render ") + kSmall + " --size 16 --force -o f_%d.png --frames 2 --path p.json ";
  EXPECT_THAT(program.run(render).output,
              HasSubstr("warning: p.json: \"fov\" changes nothing with an orthographic camera; "
                        "--projection perspective has a field of view"));
  EXPECT_THAT(program.run(render + "--projection perspective").output,
              testing::Not(HasSubstr("warning")));
}

TEST(Paths, goAlongTheStepsOfASeries) {
  const Program program;
  writeFile(program.folder / "path.json", R"({"keys": [{"at": 0, "azimuth": 0, "elevation": 10},
    {"at": 0.6, "azimuth": 180, "zoom": 2}, {"at": 1, "elevation": 60}]})");
  const std::string render =
      std::string("render ") + kSeries + " --size 24 -q --step 1 --fit volume ";
  ASSERT_EQ(program.run(render + "--time 0:3 --path path.json -o f_%d.png").status, 0);
  // The camera of frame i of four, and the step i.
  const std::string cameras[] = {"--azimuth 0 --elevation 10", "", "",
                                 "--azimuth 180 --elevation 60 --zoom 2"};
  for (const int i : {0, 3}) {
    ASSERT_EQ(program.run(render + fmt::format("--time {} {} -o one.png", i, cameras[i])).status,
              0);
    const auto a = readPng(program.folder / "one.png").rgba;
    const auto b = readPng(program.folder / fmt::format("f_{}.png", i)).rgba;
    size_t different = 0;
    for (size_t p = 0; p < a.size(); ++p) different += a[p] == b[p] ? 0 : 1;
    EXPECT_LE(different, a.size() / 100) << i;
  }
  EXPECT_NE(readFile(program.folder / "f_1.png"), readFile(program.folder / "f_0.png"));
  const CommandResult alone = program.run(render + "--path path.json -o a.png");
  EXPECT_EQ(alone.status, 2) << alone.output;
  EXPECT_THAT(alone.output, HasSubstr("--path"));
}

// Pictures do not tell how they were drawn.
TEST(ContinuedSeries, saysThatPicturesStayWhateverTheirOptions) {
  const Program program;
  const std::string render = std::string("render ") + kSeries + " --size 24 -o f_%d.png ";
  EXPECT_THAT(program.run(render + "--time 0:1 --continue").output, Not(HasSubstr("as before")));
  const std::string more = render + "--time 0:2 --continue --threshold 40 ";
  EXPECT_THAT(program.run(more + "--report r.json").output,
              HasSubstr("sluice: f_%d.png: 2 of 3 pictures are there and stay as before"));
  fs::remove(program.folder / "f_2.png");
  EXPECT_THAT(program.run(more + "--report r.json").output, Not(HasSubstr("as before")));
  EXPECT_EQ(program.run(more + "-q").output, "");
}

// Frames of a saved path were kept if a file of their name was there.
TEST(ContinuedSeries, framesOfASavedPathAreCheckedAsOtherPictures) {
  const Program program;
  std::ofstream(program.folder.path() / "view.json")
      << R"({"sluice": "view", "path": {"kind": "turn", "frames": 2}})";
  const std::string render =
      std::string("render ") + kSmall + " --state view.json --continue -o f_%d.png --size ";
  ASSERT_EQ(program.run(render + "24").status, 0);
  const std::string whole = readFile(program.folder / "f_1.png");
  std::ofstream(program.folder.path() / "f_1.png") << whole.substr(0, whole.size() / 2);
  EXPECT_THAT(program.run(render + "24").output, HasSubstr("1 of 2 pictures is there"));
  EXPECT_TRUE(readFile(program.folder / "f_1.png") == whole);
  const CommandResult other = program.run(render + "25");
  EXPECT_EQ(other.status, 1);
  EXPECT_THAT(other.output, HasSubstr("f_0.png: 24 x 24 pixels, expected 25 x 25"));
}

// A run that was cut and one that goes on give the report of the whole.
TEST(ContinuedSeries, reportsAllOfIt) {
  const Program program;
  const std::string render = std::string("render ") + kSeries + " --size 24 --this-step --time ";
  const std::string rest = " -o f_%d.png --continue --report r.json -q";
  ASSERT_EQ(program.run(render + "1:2" + rest).status, 0);
  const auto reportOf = [&] { return nlohmann::json::parse(readFile(program.folder / "r.json")); };
  const nlohmann::json first = reportOf();
  ASSERT_EQ(first["frames"].size(), 2U);
  ASSERT_EQ(program.run(render + "0:3" + rest).status, 0);
  const nlohmann::json all = reportOf();
  ASSERT_EQ(all["frames"].size(), 4U);
  EXPECT_FALSE(all.contains("frames_not_measured"));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(all["frames"][i]["time"], i);
    EXPECT_EQ(all["frames"][i]["picture"], fmt::format("f_{}.png", i));
  }
  for (int i = 0; i < 2; ++i) EXPECT_EQ(all["frames"][1 + i], first["frames"][i]);
  // Pictures that nobody measured are named.
  fs::remove(program.folder / "r.json");
  fs::remove(program.folder / "f_2.png");
  ASSERT_EQ(program.run(render + "0:3" + rest).status, 0);
  const nlohmann::json part = reportOf();
  EXPECT_EQ(part["frames"].size(), 1U);
  EXPECT_EQ(part["frames_not_measured"], nlohmann::json::array({"f_0.png", "f_1.png", "f_3.png"}));
}

TEST(ContinuedSeries, drawsPicturesThatAreNotWholeAgain) {
  const Program program;
  for (const std::string kind : {"png", "exr"}) {
    const std::string line =
        std::string("render ") + kSeries + " --this-step --time 0:3 -o f_%d." + kind;
    const auto run = [&](const std::string& rest, const std::string& size = "24") {
      return program.run(line + " --size " + size + rest);
    };
    ASSERT_EQ(run(" -q").status, 0);
    std::vector<std::string> whole;
    for (int i = 0; i < 4; ++i)
      whole.push_back(readFile(program.folder / fmt::format("f_{}.{}", i, kind)));
    const auto rewrite = [&](int i, const std::string& bytes) {
      std::ofstream(program.folder / fmt::format("f_{}.{}", i, kind), std::ios::binary) << bytes;
    };
    // Empty, cut after its header, and without its last bytes.
    rewrite(0, "");
    rewrite(1, whole[1].substr(0, whole[1].size() / 2));
    rewrite(3, whole[3].substr(0, whole[3].size() - 1));
    const CommandResult result = run(" --continue");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr("3 frames, the last"));
    for (int i = 0; i < 4; ++i)
      EXPECT_TRUE(readFile(program.folder / fmt::format("f_{}.{}", i, kind)) ==
                  whole[static_cast<size_t>(i)])
          << kind << " " << i;
    EXPECT_THAT(run(" --continue").output, HasSubstr("all 4 pictures are there"));
    // Pictures of other options, or of another program.
    const CommandResult other = run(" --continue", "32x24");
    EXPECT_EQ(other.status, 1);
    EXPECT_THAT(other.output, HasSubstr("24 x 24 pixels, expected 32 x 24"));
    if (kind != "png") continue;
    std::string unmarked = whole[2];
    unmarked.replace(unmarked.find("sluice"), 6, "others");
    rewrite(2, unmarked);
    const CommandResult foreign = run(" --continue");
    EXPECT_EQ(foreign.status, 1);
    EXPECT_THAT(foreign.output, HasSubstr("f_2.png"));
  }
}

TEST(ContinuedSeries, warnsOfPicturesOfOtherOptions) {
  const Program program;
  const std::string line = std::string("render ") + kSeries + " --size 24 --this-step";
  const std::string rest = " -o f_%d.png --continue --report r.json";
  ASSERT_EQ(program.run(line + " --threshold 50 --time 0:1" + rest).status, 0);
  const std::string same =
      program.run(line + " --threshold 50 --threads 1 --time 0:2" + rest).output;
  EXPECT_THAT(same, Not(HasSubstr("warning")));
  const std::string other = program.run(line + " --threshold 10 --time 0:3" + rest).output;
  EXPECT_THAT(other, HasSubstr("r.json: the pictures that are there may look otherwise: their run "
                               "had '50' for --threshold, this one has '10'"));
}

TEST(ContinuedSeries, aSignalLeavesAReportOfWhatWasDrawn) {
  const Program program;
  const std::string line = std::string("render ") + kSmall +
                           " --size 64 --frames 5000 -o f_%d.png --continue --report r.json";
  const CommandResult cut = program.signalled(line, "INT", "[ -e f_3.png ]");
  ASSERT_EQ(cut.status, 130) << cut.output;
  const auto report = nlohmann::json::parse(readFile(program.folder / "r.json"));
  const size_t drawn = report["frames"].size();
  EXPECT_GE(drawn, 3U);
  EXPECT_TRUE(program.exists(fmt::format("f_{}.png", drawn - 1)));
}

}  // namespace
}  // namespace sluice
