// Pictures that show nothing report why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <vector>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

int warnings(const std::string& output) {
  int count = 0;
  for (size_t at = output.find("warning: "); at != std::string::npos;
       at = output.find("warning: ", at + 1))
    ++count;
  return count;
}

TEST(EmptyPicture, saysWhyInOneLine) {
  const Program program;
  struct Case {
    const char *options, *why;
  };
  const Case cases[] = {
      {"--opacities 300:0,400:1", "gives all values of the volume, 0 to"},
      {"--opacities 0:0,255:0", "has opacity 0 everywhere"},
      {"--threshold 90 --opacity 0", "has opacity 0 everywhere"},
      {"--threshold 90 --crop 500,0,0,600,40,36", "lies outside of the volume's 48 x 40 x 36"},
      {"--threshold 90 --crop 0,0,0,3,3,3", "inside the crop box"},
      {"--threshold 90 --projection perspective --eye 0,0,-300 --target 0,0,-400",
       "looks past the visible part"},
      {"--threshold 90 --eye 0,0,-300 --target 900,0,-300", "looks past the visible part"},
      {"--threshold 90 --clip 1,0,0,-5", "takes away all"},
      {"--threshold 90 --opacity 1e-9", "too transparent"},
      {"--mode mip --threshold 90 --crop 0,0,0,3,3,3", "inside the crop box"},
  };
  for (const Case& each : cases) {
    const CommandResult result = program.run(std::string("render ") + kSmall +
                                             " -o a.png --size 40x40 --force " + each.options);
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr("sluice: warning: a.png shows nothing: ")) << each.options;
    EXPECT_THAT(result.output, HasSubstr(each.why)) << each.options;
    EXPECT_EQ(warnings(result.output), 1) << result.output;
  }
  EXPECT_EQ(program
                .run(std::string("render ") + kSmall +
                     " -o a.png --size 40x40 --force -q --threshold 90 --opacity 0")
                .output,
            "");
}

template <class T>
void writeVolume(const Program& program, const char* name, const std::vector<T>& voxels) {
  std::ofstream(program.folder / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(voxels.data()),
             static_cast<std::streamsize>(voxels.size() * sizeof(T)));
}

TEST(EmptyPicture, noFiniteNumberIsSaidSo) {
  const Program program;
  writeVolume(program, "nan_8x8x8_float32.raw",
              std::vector<float>(512, std::numeric_limits<float>::quiet_NaN()));
  const std::string said = program.run("render nan_8x8x8_float32.raw -o a.png --size 20").output;
  EXPECT_THAT(said, HasSubstr("a.png shows nothing: no voxel is a finite number"));
  const std::string info = program.run("info nan_8x8x8_float32.raw").output;
  EXPECT_THAT(info, HasSubstr("no value is a finite number"));
  EXPECT_THAT(info, HasSubstr("1 block of 32 a side, 0 of them not all NaN"));
  EXPECT_THAT(info, Not(HasSubstr("look")));
  EXPECT_THAT(program.run("surface nan_8x8x8_float32.raw --iso 1 -o a.ply").output,
              HasSubstr("no surface at 1, the mesh is empty: no value is a finite number"));
  writeVolume(program, "high_8x8x8_uint32.raw", std::vector<uint32_t>(512, 2147483646));
  EXPECT_THAT(
      program.run("surface high_8x8x8_uint32.raw --iso 2147483640 -o b.ply").output,
      HasSubstr("no surface at 2147483640, the mesh is empty: values are from 2147483648 to"));
}

// Next to the picture that shows something else than its values say.
TEST(EmptyPicture, valuesThatFloatsMergeAreNamed) {
  const Program program;
  std::vector<uint32_t> labels(512, 16777216);
  labels[3] = 16777217;
  writeVolume(program, "labels_8x8x8_uint32.raw", labels);
  EXPECT_THAT(program.run("info labels_8x8x8_uint32.raw").output,
              HasSubstr("integers of 32 bits are drawn as floats, which are 2 apart"));
  std::vector<double> doubles(512, 1e6);
  doubles[3] = 1e6 + 0.02;
  writeVolume(program, "doubles_8x8x8_float64.raw", doubles);
  EXPECT_THAT(program.run("info doubles_8x8x8_float64.raw").output,
              HasSubstr("doubles are drawn as floats, which are 0.0625 apart"));
  labels.assign(512, 16777215);
  doubles[3] = 3e6;
  writeVolume(program, "labels_8x8x8_uint32.raw", labels);
  writeVolume(program, "doubles_8x8x8_float64.raw", doubles);
  for (const char* name : {"labels_8x8x8_uint32.raw", "doubles_8x8x8_float64.raw"})
    EXPECT_THAT(program.run(std::string("info ") + name).output, Not(HasSubstr("apart")));
}

TEST(EmptyPicture, aThresholdIsComparedWithTheValuesNotWithTheColours) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " -o a.png --size 40 --force ";
  EXPECT_THAT(program.run(line + "--threshold 90 --range 5,50").output, Not(HasSubstr("shows")));
  EXPECT_THAT(program.run(line + "--threshold 900 --range 5,5000").output,
              HasSubstr("--threshold 900: nothing shows, the values are 0 to"));
}

TEST(EmptyPicture, othersSayNothing) {
  const Program program;
  const CommandResult result =
      program.run(std::string("render ") + kSmall + " -o a.png --size 40x40 --threshold 90");
  EXPECT_THAT(result.output, Not(HasSubstr("warning")));
}

TEST(EmptyPicture, ofSeveralHasOneLineAndTheReportEachReason) {
  const Program program;
  const std::string line =
      std::string("render ") + kSmall +
      " -o a_####.png --size 40x40 --frames 3 --threshold 90 --crop 0,0,0,3,3,3";
  const CommandResult result = program.run(line);
  EXPECT_EQ(warnings(result.output), 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("; 2 more of the 3 pictures show nothing"));
  const auto report = program.json(line + " --force");
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(report["frames"][i]["empty"].get<std::string>(), HasSubstr("crop box"));
}

TEST(EmptyPicture, aCropOfOneVoxelPlaneShowsIt) {
  const Program program;
  for (const char* options : {"composite", "mip", "minip", "composite --iso 90", "mip --device gl",
                              "composite --partition boxes", "composite --labels"}) {
    const CommandResult result =
        program.run(std::string("render ") + kSmall +
                    " -o a.png --force --crop 0,0,15,48,40,16 --mode " + options);
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_EQ(warnings(result.output), 0) << result.output;
  }
  // The first plane and the last one have a neighbour on one side alone.
  for (const char* crop : {"0,0,0,48,40,1", "0,39,0,48,40,32", "47,0,0,48,40,32"})
    EXPECT_EQ(program
                  .run(fmt::format("render {} -o b.png --force --threshold 0 --crop {} --verify",
                                   kSmall, crop))
                  .status,
              0)
        << crop;
  const CommandResult none =
      program.run(std::string("render ") + kSmall + " -o c.png --crop 0,0,5,48,40,5");
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.output, HasSubstr("each upper one above the lower"));
}

}  // namespace
}  // namespace sluice
