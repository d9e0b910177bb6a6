// The printed look, given back as options, draws the same picture, byte for byte: with the light
// and the samples that the user chose, and with another volume over the first.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kVoxels = 32;

// Bodies of three labels in nothing.
std::string labelVoxels() {
  std::string voxels;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const bool is_inside = x % 16 > 3 && x % 16 < 12 && y > 6 && y < 26 && z > 4 && z < 24;
        voxels += static_cast<char>(is_inside ? 1 + x / 16 + z / 16 : 0);
      }
  return voxels;
}
// A bright spot with a rim.
std::string spotVoxels() {
  std::string voxels;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const int square = (x - 20) * (x - 20) + (y - 14) * (y - 14) + (z - 16) * (z - 16);
        voxels += static_cast<char>(std::max(0, 250 - 2 * square));
      }
  return voxels;
}

class PrintedLook : public testing::Test {
 protected:
  void SetUp() override {
    writeFile(program_.folder / kLabels, labelVoxels());
    writeFile(program_.folder / kSpot, spotVoxels());
    writeFile(program_.folder / "t.ctbl", "1 one 255 0 0 255\n2 two 0 255 0 102\n");
  }
  // The options that `render` prints with these arguments and settings. `arguments` are those that
  // no look has: the volumes, the view, the mode.
  std::string look(const std::string& arguments, const std::string& settings) const {
    const auto optionsOf = [&](const std::string& name, const std::string& options) {
      const auto report = program_.json(
          fmt::format("render {} {} --force --size 48x40 -o {}", arguments, options, name));
      return report["look"]["options"].get<std::string>();
    };
    std::string printed = optionsOf("first.png", settings);
    EXPECT_EQ(optionsOf("again.png", printed), printed);
    EXPECT_TRUE(readFile(program_.folder / "first.png") == readFile(program_.folder / "again.png"))
        << arguments << " " << settings << "\n"
        << printed;
    return printed;
  }

  static constexpr const char* kLabels = "labels_32x32x32_uint8.raw";
  static constexpr const char* kSpot = "spot_32x32x32_uint8.raw";
  const Program program_;
};

// Factors and floats leave no digits of rounding, in what is printed or in what is drawn.
TEST_F(PrintedLook, hasNoDigitsOfRounding) {
  std::string floats;
  for (const char c : spotVoxels()) {
    const float value = 0.1F * static_cast<float>(1 + static_cast<unsigned char>(c) / 36);
    floats.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  writeFile(program_.folder / "f_32x32x32_float32.raw", floats);
  EXPECT_THAT(look("f_32x32x32_float32.raw --mode mip", ""), HasSubstr("--range 0.1,0.7"));
  // Far off 0, as many digits stay as the values differ in.
  writeFile(program_.folder / "far.mhd",
            "ObjectType = Image\nNDims = 3\nDimSize = 32 32 32\nElementType = MET_UCHAR\n"
            "ElementToIntensityFunctionSlope = 0.1\n"
            "ElementToIntensityFunctionOffset = 100000000000\n"
            "ElementDataFile = far.raw\n");
  writeFile(program_.folder / "far.raw",
            std::string(16 * 32 * 32, '\0') + std::string(16 * 32 * 32, '\xd4'));
  EXPECT_THAT(look("far.mhd --mode mip", ""), HasSubstr("--range 100000000000,100000000021.2"));
  for (const char* volume : {kSpot, "f_32x32x32_float32.raw"})
    for (const char* settings : {"", "--opacity 1", "--opacity 0.7", "--opacity 0.003",
                                 "--modulate --range 0.3,3", "--threshold 0.3 --opacity 0.3"}) {
      const std::string printed = look(volume, settings);
      size_t digits = 0, most = 0;
      for (const char c : printed) {
        digits = std::isdigit(static_cast<unsigned char>(c)) != 0 ? digits + 1
                 : c == '.'                                       ? digits
                                                                  : 0;
        most = std::max(most, digits);
      }
      EXPECT_LE(most, 13U) << printed;
    }
}

TEST_F(PrintedLook, givesTheLightThatTheUserChose) {
  for (const char* settings : {"",
                               "--threshold 40 --shadows --light 60,20",
                               "--light=-60,-20 --ambient 0.1",
                               "--diffuse 0.2 --specular 0.9",
                               "--shadows=0.4 --occlusion-light",
                               "--occlusion-light=0.5",
                               "--depth-cueing",
                               "--depth-cueing=0.6 --no-shade",
                               "--jitter",
                               "--jitter=0.3 --no-shade",
                               "--quality high --light 10,10",
                               "--step 0.3 --shadows",
                               "--iso 100,180:0.4 --shadows=0.7",
                               "--iso 100 --threshold 60 --light 50,50",
                               "--modulate --light 40,0",
                               "--modulate --iso 100:0.5",
                               "--modulate --full-gradient 0.3 --threshold 50",
                               "--opacities 40:0,255:0.3 --map viridis --ambient 0.5",
                               "--map green --range 40,200",
                               "--opacity 0.2 --specular 0"}) {
    SCOPED_TRACE(settings);
    look(kSmall, settings);
    look(std::string(kSpot) + " --projection perspective", settings);
  }
  for (const char* settings : {"--labels --shadows", "--labels-table t.ctbl --light 40,40",
                               "--labels-table t.ctbl --opacity 0.3", "--label 1=red --jitter",
                               "--labels --modulate --full-gradient 0.3 --range 1,2",
                               "--look 0:t.ctbl,0.5", "--look 0:labels --shade --ambient 0.6"}) {
    SCOPED_TRACE(settings);
    look(kLabels, settings);
  }
}

TEST_F(PrintedLook, hasTheOptionsThatCountAndNoOthers) {
  EXPECT_THAT(look(kSmall, "--threshold 40 --shadows --light=-60,20"),
              HasSubstr(" --shade --step 0.25 --light=-60,20 --shadows=1"));
  EXPECT_THAT(look(kSmall, "--threshold 40 --light 60,20 --no-shade"), Not(HasSubstr("--light")));
  EXPECT_THAT(look(std::string(kSmall) + " --mode mip", "--light 60,20 --ambient 0.5"),
              AllOf(Not(HasSubstr("--light")), Not(HasSubstr("--ambient"))));
  const CommandResult run =
      program_.run(fmt::format("render {} -o a.exr --size 32 --depth-cueing=0.5", kSmall));
  EXPECT_THAT(run.output, HasSubstr(" --depth-cueing=0.5\n"));
}

TEST_F(PrintedLook, ofOtherModesGivesTheSamePicture) {
  for (const char* mode : {"mip", "minip", "average", "attenuated-mip", "depth-mip"})
    for (const char* settings : {"", "--threshold 60", "--threshold 60 --range 200,20",
                                 "--map red --range 20,200", "--step 0.3"}) {
      SCOPED_TRACE(fmt::format("{} {}", mode, settings));
      look(fmt::format("{} --mode {}", kSmall, mode), settings);
      look(fmt::format("{} --over {} --mode {}", kSpot, kLabels, mode), settings);
    }
  look(fmt::format("{} --over {} --mode attenuated-mip", kSpot, kLabels),
       "--look 0:red --attenuation 0.4");
  for (const char* mode : {"average", "attenuated-mip"})
    EXPECT_THAT(look(fmt::format("{} --mode {}", kSmall, mode), "--step 7"), HasSubstr("--step 7"));
  EXPECT_THAT(look(std::string(kSmall) + " --mode mip", ""), Not(HasSubstr("--step")));
}

// A value has the same grey with any threshold below it. It is the only one: nothing else is known.
TEST_F(PrintedLook, aThresholdLeavesTheColoursWhereTheRangeHasThem) {
  writeFile(program_.folder / "even_16x16x16_uint8.raw", std::string(16 * 16 * 16, '\x82'));
  const auto greyOf = [&](const std::string& settings) {
    const CommandResult drawn = program_.run(
        "render even_16x16x16_uint8.raw --force -q --no-shade --map grey --view front --size 24x24 "
        "-o a.png " +
        settings);
    EXPECT_EQ(drawn.status, 0) << drawn.output;
    const Rgba8Picture picture = readPng(program_.folder / "a.png");
    const uint8_t* const middle = &picture.rgba[4 * (12 * 24 + 12)];
    return middle[3] == 0 ? -1 : middle[0] * middle[3] / 255;
  };
  struct Row {
    const char* range;
    double share;  // of white, for value 130
  };
  for (const Row& row : {Row{"20,220", 110.0 / 200},
                         {"220,20", 90.0 / 200},
                         {"130,330", 0},
                         {"0,520", 0.25},
                         {"100,160", 0.5}})
    for (const char* threshold : {"", "--threshold 100", "--threshold 21.5", "--threshold -7"})
      for (const auto& [mode, more] : {std::pair("--mode mip", ""),
                                       {"--mode minip", ""},
                                       {"--mode average", ""},
                                       {"--mode attenuated-mip", "--attenuation 0"},
                                       {"--mode composite", "--opacity 1"}}) {
        const bool is_composite = std::string_view(mode) == "--mode composite";
        if (*threshold == 0 && is_composite) continue;
        const std::string settings = fmt::format("--range {} {} {}", row.range, threshold, more);
        EXPECT_NEAR(greyOf(fmt::format("{} {}", mode, settings)), 255 * row.share, 1.5)
            << mode << " " << settings;
        look(fmt::format("even_16x16x16_uint8.raw {}", mode), settings);
      }
  EXPECT_EQ(greyOf("--threshold 140 --range 20,220 --mode mip"), -1);
}

// --shade lights both volumes, and without it the first one alone is lit.
TEST_F(PrintedLook, givesTheLightOfBothVolumes) {
  for (const char* over : {kLabels, kSpot})
    for (const char* settings :
         {"", "--shade", "--no-shade", "--threshold 60 --shadows",
          "--shade --shadows --light 50,10", "--look over:green,20:200,0.3",
          "--iso 100:0.5 --ambient 0.5", "--combine blend", "--combine blend --shade",
          "--look over:labels,0.3", "--look over:t.ctbl", "--look over:t.ctbl,0.5 --shade",
          "--look 0:green", "--look 0:green,40:200 --shade --light 40,40",
          "--look 0:green --iso 60:0.5 --shade"}) {
      SCOPED_TRACE(fmt::format("{} {}", over, settings));
      look(fmt::format("{} --over {}", over == kLabels ? kSpot : kLabels, over), settings);
    }
  EXPECT_THAT(look(fmt::format("{} --over {}", kSpot, kLabels), ""), Not(HasSubstr("--shade")));
}

}  // namespace
}  // namespace sluice
