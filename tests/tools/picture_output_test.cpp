// The pictures that `render` writes: EXR for compositing, annotations, names, and views.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSmallLook = " --threshold 60 --size 64x48 ";

std::string attributeOf(const ExrContents& exr, const std::string& wanted) {
  for (const auto& [name, text] : exr.attributes)
    if (name == wanted) return text;
  return "";
}

TEST(PictureOutput, anExrHoldsDepthAndTheSettingsThatMakeItAgain) {
  const Program program;
  for (const std::string view :
       {"--view plain --azimuth 33 --elevation 12", "--view plain --projection perspective",
        "--zoom 1.3", "--projection perspective --view top --azimuth 20 --up 0.1,1,0.2",
        "--fit volume --view left", "--eye 90,80,70 --target 20,20,20 --projection perspective",
        "--eye 90,80,70 --target 20,20,20 --up 0,0,1"}) {
    SCOPED_TRACE(view);
    const CommandResult made =
        program.run(std::string("render ") + kSmall + " -o a.exr --size 48x40 --step 0.7 " + view);
    ASSERT_EQ(made.status, 0) << made.output;
    const ExrContents first = readExr(program.folder / "a.exr");
    ASSERT_EQ(first.picture.depth.size(), 48U * 40);
    EXPECT_TRUE(std::any_of(first.picture.depth.begin(), first.picture.depth.end(),
                            [](float d) { return std::isfinite(d) && d > 0; }));
    writeFile(program.folder / "t.json", attributeOf(first, "transferFunction"));
    const CommandResult again =
        program.run(std::string("render ") + kSmall + " -o b.exr --transfer t.json " +
                    attributeOf(first, "camera"));
    ASSERT_EQ(again.status, 0) << again.output;
    const ExrContents second = readExr(program.folder / "b.exr");
    double most = 0;
    for (size_t i = 0; i < first.picture.rgba.size(); ++i)
      most = std::max<double>(most, std::abs(first.picture.rgba[i] - second.picture.rgba[i]));
    EXPECT_LT(most, 1e-3);
  }
}

// OpenImageIO reads both, knows linear light, and prints the header.
TEST(PictureOutput, anExrIsThePngInLinearLight) {
  if (std::system("/usr/bin/python3 -c 'import numpy, OpenImageIO' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3 with numpy and OpenImageIO is missing";
  const Program program;
  for (const std::string look : {"", " --background 306090", " --mode mip", " --shade"}) {
    SCOPED_TRACE(look);
    for (const char* file : {"a.exr", "a.png"})
      ASSERT_EQ(
          program.run(std::string("render ") + kSmall + kSmallLook + "-o " + file + look).status,
          0);
    const auto run =
        program.inFolder("/usr/bin/python3 " SLUICE_TEST_DIR "/io/read_exr_oiio.py a.exr a.png");
    ASSERT_EQ(run.status, 0) << run.output;
    const size_t at = run.output.find("difference ");
    ASSERT_NE(at, std::string::npos) << run.output;
    EXPECT_LE(std::stod(run.output.substr(at + 11)), 1.0 / 255);
    EXPECT_THAT(run.output, AllOf(HasSubstr("display 0 0 64 48\ndata 0 0 64 48\n"),
                                  HasSubstr("PixelAspectRatio float 1\n"),
                                  // OpenImageIO's own word for it, or OpenEXR's: by version.
                                  AnyOf(HasSubstr("attribute worldtocamera matrix"),
                                        HasSubstr("attribute worldToCamera matrix")),
                                  HasSubstr("attribute worldToNDC matrix")));
    if (look.empty()) {
      EXPECT_THAT(run.output, AllOf(HasSubstr("channels R G B A Z\n"), HasSubstr("depth True True"),
                                    HasSubstr("depthWhereNothingIs string infinity")));
    }
  }
}

TEST(PictureOutput, openExrsOwnToolNamesTheMatrices) {
  if (std::system("command -v exrheader >/dev/null") != 0) GTEST_SKIP() << "exrheader is missing";
  const Program program;
  ASSERT_EQ(program.run(std::string("render ") + kSmall + kSmallLook + "-o a.exr").status, 0);
  const auto run = runCommand("exrheader " + (program.folder / "a.exr").string());
  EXPECT_THAT(
      run.output,
      AllOf(HasSubstr("worldToCamera (type m44f)"), HasSubstr("worldToNDC (type m44f)"),
            HasSubstr("chromaticities (type chromaticities)"), HasSubstr("(0 0) - (63 47)")));
}

TEST(PictureOutput, channelsAreThoseAskedFor) {
  const Program program;
  const auto channelsOf = [&](const std::string& options) {
    const CommandResult made =
        program.run(std::string("render ") + kSmall + kSmallLook + "-o a.exr " + options);
    EXPECT_EQ(made.status, 0) << made.output;
    return readExr(program.folder / "a.exr");
  };
  const ExrContents none = channelsOf("--aov none");
  EXPECT_TRUE(none.picture.depth.empty());
  EXPECT_TRUE(none.channels.empty());
  const ExrContents both = channelsOf("--aov opacity,depth --background ffffff");
  EXPECT_FALSE(both.picture.depth.empty());
  ASSERT_EQ(both.channels.size(), 1U);
  EXPECT_EQ(both.channels[0].name, "opacity");
  for (size_t i = 0; i < both.channels[0].values.size(); ++i) {
    EXPECT_NEAR(both.channels[0].values[i], none.picture.rgba[4 * i + 3], 1e-4) << i;
    EXPECT_EQ(both.picture.rgba[4 * i + 3], 1);
  }
  EXPECT_TRUE(channelsOf("--mode mip").picture.depth.empty());
}

TEST(PictureOutput, whatDoesNotGoTogetherIsRefused) {
  const Program program;
  const auto lineOf = [&](const std::string& options, int status) {
    const CommandResult result = program.run(std::string("render ") + kSmall + " " + options);
    EXPECT_EQ(result.status, status) << result.output;
    return result.output;
  };
  EXPECT_THAT(lineOf("-o a.png --aov depth", 2), HasSubstr("--aov"));
  EXPECT_THAT(lineOf("-o a.exr --annotate", 2), HasSubstr("--annotate"));
  EXPECT_THAT(lineOf("-o a.exr --aov depth --mode mip", 2), HasSubstr("--mode composite"));
  EXPECT_THAT(lineOf("-o a.exr --aov color", 2), HasSubstr("depth"));
  for (const char* size : {"100", "32", "1x1", "2000x4"})
    EXPECT_THAT(lineOf("-o a.png --annotate --size " + std::string(size), 2),
                HasSubstr("128 x 128"));
  EXPECT_THAT(lineOf("-o a.png --view fornt", 2), HasSubstr("three-quarter"));
  EXPECT_THAT(lineOf("-o a.png --up 0,0,0", 1), HasSubstr("up direction"));
  for (const char* turned : {"--azimuth 3", "--elevation 3", "--view front", "--fit volume"})
    EXPECT_THAT(lineOf(std::string("-o a.png --eye 9,9,9 --target 0,0,0 ") + turned, 2),
                HasSubstr("--eye"));
}

TEST(PictureOutput, extensionsCountInAnyCase) {
  const Program program;
  for (const char* file : {"a.PNG", "b.Png", "c.EXR"})
    EXPECT_EQ(program.run(std::string("render ") + kSmall + " --size 32 -o " + file).status, 0);
  EXPECT_EQ(readPng(program.folder / "a.PNG").width, 32);
  EXPECT_EQ(readExr(program.folder / "c.EXR").picture.width, 32);
}

TEST(PictureOutput, annotationsStandBesideTheVolumeInEveryFrame) {
  const Program program;
  const std::string turn = std::string("render ") + kSmall +
                           " --threshold 60 --size 200 --background ffffff --frames 2 ";
  ASSERT_EQ(program.run(turn + "-o plain.png").status, 0);
  ASSERT_EQ(program.run(turn + "-o with.png --annotate").status, 0);
  const Rgba8Picture first = readPng(program.folder / "with_000.png"),
                     second = readPng(program.folder / "with_001.png");
  // The colour bar is the same in both, the axes turn with the volume.
  const auto differs = [&](int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 4 * x0; x < 4 * x1; ++x)
        if (first.rgba[static_cast<size_t>(y * 800 + x)] !=
            second.rgba[static_cast<size_t>(y * 800 + x)])
          return true;
    return false;
  };
  EXPECT_FALSE(differs(160, 0, 200, 200));
  EXPECT_TRUE(differs(0, 150, 55, 200));
}

TEST(PictureOutput, aBarOfARangeIsTheSameHoweverAStepIsAskedFor) {
  const Program program;
  for (const int step : {0, 1})
    std::ofstream(program.folder / fmt::format("step_{}_8x8x8_uint8.raw", step))
        << std::string(256, static_cast<char>(20)) +
               std::string(256, static_cast<char>(60 + 40 * step));
  const std::string line =
      "render step_#_8x8x8_uint8.raw --range 0,120 --opacities 10:0,120:0.3 --view plain "
      "--annotate "
      "--size 150x300 --device cpu -q ";
  ASSERT_EQ(program.run(line + "--time 0 -o one.png").status, 0);
  ASSERT_EQ(program.run(line + "--time 0:1 -o more_#.png").status, 0);
  EXPECT_TRUE(readFile(program.folder / "one.png") == readFile(program.folder / "more_0.png"));
}

// The visible pixels of a picture: mean row and their number.
std::pair<double, int> shownAt(const Rgba8Picture& picture) {
  double rows = 0;
  int count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (picture.rgba[4 * (static_cast<size_t>(y) * static_cast<size_t>(picture.width) +
                            static_cast<size_t>(x)) +
                       3] > 40) {
        rows += y;
        ++count;
      }
  return {count == 0 ? 0 : rows / count, count};
}

// A ball that rises by a third of its volume from step to step.
void writeRisingBall(const std::filesystem::path& folder) {
  constexpr int kSide = 32, kRise = 8;
  for (int step = 0; step < 3; ++step) {
    std::string voxels;
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const double dx = x - 16, dy = y - 8 - kRise * step, dz = z - 16;
          voxels += static_cast<char>(dx * dx + dy * dy + dz * dz < 36 ? 200 : 0);
        }
    writeFile(folder / fmt::format("ball_{}.raw", step), voxels);
  }
}

TEST(PictureOutput, whatRisesInASeriesRisesInItsPictures) {
  const Program program;
  writeRisingBall(program.folder.path());
  const auto draw = [&](int step, const std::string& options) {
    const CommandResult made = program.run(
        fmt::format("render 'ball_%d.raw' --dims 32,32,32 --type u8 --threshold 100 --opacity 1 "
                    "--size 90 -o a.png --time {} {}",
                    step, options));
    EXPECT_EQ(made.status, 0) << made.output;
    return shownAt(readPng(program.folder / "a.png"));
  };
  const auto [row0, count0] = draw(0, "");
  const auto [row1, count1] = draw(1, "");
  const auto [row2, count2] = draw(2, "");
  EXPECT_NEAR(row0 - row1, row1 - row2, 1);
  EXPECT_GT(row0 - row1, 15);
  EXPECT_NEAR(count0, count2, 0.03 * count0) << "of one size";
  // Asked for, each step fills its picture.
  const auto [alone0, large0] = draw(0, "--this-step");
  const auto [alone2, large2] = draw(2, "--this-step");
  EXPECT_NEAR(alone0, alone2, 1);
  EXPECT_GT(large0, 2 * count0);
  EXPECT_NEAR(large0, large2, 0.02 * large0);
  // All pictures of a range have the first one's look and fit.
  const CommandResult range = program.run(
      "render 'ball_%d.raw' --dims 32,32,32 --type u8 --threshold 100 --opacity 1 "
      "--size 90 -o r_%d.png --time 1:2 --this-step");
  ASSERT_EQ(range.status, 0) << range.output;
  draw(1, "--this-step");
  EXPECT_TRUE(readFile(program.folder / "r_1.png") == readFile(program.folder / "a.png"));
  EXPECT_GT(shownAt(readPng(program.folder / "r_1.png")).first,
            shownAt(readPng(program.folder / "r_2.png")).first + 15);
}

TEST(PictureOutput, whatIsVisibleFillsThePictureAlsoOfACrop) {
  const Program program;
  const auto shareOf = [&](const std::string& options) {
    const CommandResult made = program.run(
        "render synth:shells,dims=64x64x64 --threshold 60 --opacity 1 --size 80 "
        "-o a.png --view front " +
        options);
    EXPECT_EQ(made.status, 0) << made.output;
    return shownAt(readPng(program.folder / "a.png")).second / 6400.0;
  };
  const double cropped = shareOf("--crop 20,20,20,44,44,44");
  EXPECT_GT(cropped, 4 * shareOf("--fit volume --crop 20,20,20,44,44,44"));
  EXPECT_GT(cropped, 0.4);
}

// Pictures that are compared with other renderers and benches stay as they were.
TEST(PictureOutput, thePlainViewHasTheVolumesSphere) {
  const Program program;
  ASSERT_EQ(
      program.run(std::string("render ") + kSmall + kSmallLook + "-o a.exr --view plain").status,
      0);
  const std::string camera = attributeOf(readExr(program.folder / "a.exr"), "camera");
  EXPECT_THAT(camera, AllOf(HasSubstr("--view plain"), HasSubstr("--fit volume"),
                            HasSubstr("--azimuth 0 --elevation 0"), HasSubstr("--zoom 1 "),
                            Not(HasSubstr("--eye"))));
}

}  // namespace
}  // namespace sluice
