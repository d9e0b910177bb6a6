// Pictures of extremes and of labels from coarser levels that hold extremes and labels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class ExtremeLevels : public testing::Test {
 protected:
  std::string run(const std::string& command) const {
    const CommandResult result = program_.run(command);
    EXPECT_EQ(result.status, 0) << result.output;
    return result.output;
  }
  void pack(const std::string& how) const {
    run("pack synth:phantom,dims=128x120x112 -o " + how +
        ".zarr --chunk 16 --levels 3 --downsample " + how);
  }
  // The report of a picture in which, at 64 pixels a side, a voxel of level 1 is about a pixel
  // wide.
  json render(const std::string& volume, const std::string& more = "", int size = 64) const {
    return program_.json("render " + volume +
                         " --map grey --range 0,255 --opacities 0:1 --no-shade --view plain "
                         "--azimuth 20 --fit volume --block 16 -o x.png --force --size " +
                         std::to_string(size) + " " + more);
  }
  std::vector<uint8_t> picture() const {
    const auto rgba = readPng(program_.folder / "x.png").rgba;
    return {rgba.begin(), rgba.end()};
  }
  // The red of each pixel that shows something.
  std::vector<uint8_t> reds() const {
    const std::vector<uint8_t> rgba = picture();
    std::vector<uint8_t> reds;
    for (size_t i = 0; i < rgba.size(); i += 4)
      if (rgba[i + 3] == 255) reds.push_back(rgba[i]);
    return reds;
  }
  static double meanDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
    return sum / static_cast<double>(a.size());
  }
  // Chunks have checksums: reading one of these is an error.
  void spoilLevelZero(const std::string& store) const {
    for (const auto& file : fs::recursive_directory_iterator(program_.folder / store / "0"))
      if (file.is_regular_file() && file.path().filename().string().front() != '.')
        writeFile(file.path(), "spoilt");
  }
  const Program program_;
};

TEST_F(ExtremeLevels, areDrawnByDefaultAndSaid) {
  for (const auto& [how, mode, values] :
       {std::tuple{"max", "mip", "maxima"}, {"min", "minip", "minima"}}) {
    SCOPED_TRACE(how);
    pack(how);
    const std::string store = std::string(how) + ".zarr", option = std::string("--mode ") + mode;
    EXPECT_THAT(run("info " + store + " --levels"),
                HasSubstr(std::string(values) + ", spread: none"));
    const json report = render(store, option);
    EXPECT_EQ(report["cut"]["values"], values);
    EXPECT_EQ(report["cut"]["levels"][0]["level"], 1);
    EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
    const auto coarse = picture();
    EXPECT_FALSE(render(store, option + " --level 0").contains("cut"));
    EXPECT_LT(meanDifference(coarse, picture()), 3);
  }
  // Means do not show them.
  pack("mean");
  EXPECT_FALSE(render("mean.zarr", "--mode mip").contains("cut"));
}

// The brightest voxel stays as bright at every level, where a mean has an eighth, a 64th and so on.
TEST_F(ExtremeLevels, oneBrightVoxelShowsAtEveryLevel) {
  constexpr size_t kSide = 96;
  std::string voxels(kSide * kSide * kSide, '\0');
  for (const auto& [x, y, z] : {std::tuple{33, 51, 40}, {70, 20, 77}})
    voxels[(static_cast<size_t>(z) * kSide + static_cast<size_t>(y)) * kSide +
           static_cast<size_t>(x)] = '\xff';
  writeFile(program_.folder / "one_96x96x96_uint8.raw", voxels);
  run("pack one_96x96x96_uint8.raw -o one.zarr --chunk 16 --levels 3 --downsample max");
  for (const int level : {1, 2, 3}) {
    render("one.zarr", "--mode mip --level " + std::to_string(level), 192);
    const auto drawn = picture();
    EXPECT_GT(*std::ranges::max_element(drawn), 180) << level;
  }
}

// One ray a pixel may pass far from the middle of a coarse voxel that is smaller than the pixel.
// With several, the voxel shows from any side, as bright or dark as it is but for interpolation.
TEST_F(ExtremeLevels, oneVoxelKeepsItsBrightnessWithSeveralRaysAPixel) {
  constexpr size_t kSide = 96, kVoxel = (40 * kSide + 51) * kSide + 33;
  const auto packed = [&](const std::string& how, char others, char voxel) {
    std::string voxels(kSide * kSide * kSide, others);
    voxels[kVoxel] = voxel;
    writeFile(program_.folder / "v_96x96x96_uint8.raw", voxels);
    run("pack v_96x96x96_uint8.raw -o " + how + ".zarr --chunk 16 --levels 3 --downsample " + how);
  };
  packed("max", '\0', '\xff');
  packed("min", '\xff', '\0');
  constexpr int kShown = 150;
  for (const int size : {30, 41, 47, 52})
    for (const char* const view : {"", " --elevation 21"}) {
      SCOPED_TRACE(std::to_string(size) + view);
      const json report = render("max.zarr", std::string("--mode mip --keep-thin") + view, size);
      EXPECT_GE(report["cut"]["levels"][0]["level"], 1);
      EXPECT_EQ(report["cut"]["thin_blocks"], 0);
      const std::vector<uint8_t> bright = reds();
      EXPECT_GT(*std::ranges::max_element(bright), kShown);
      render("min.zarr", std::string("--mode minip --keep-thin") + view, size);
      const std::vector<uint8_t> dark = reds();
      EXPECT_LT(*std::ranges::min_element(dark), 255 - kShown);
    }
}

TEST_F(ExtremeLevels, areDrawnWithoutReadingLevelZero) {
  pack("max");
  render("max.zarr", "--mode mip");
  const auto known = picture();
  fs::remove_all(program_.folder / "cache");
  spoilLevelZero("max.zarr");
  const json report = render("max.zarr", "--mode mip");
  EXPECT_EQ(report["volume"]["values_level"], 1);
  EXPECT_LT(meanDifference(known, picture()), 0.5);
  // Coarse first, as with means.
  const json refined = render("max.zarr", "--mode mip --time-limit 60s");
  EXPECT_GE(refined["frames"][0]["pictures"].size(), 2U);
  EXPECT_EQ(refined["cut"]["final"], true);
}

// One store may hold levels for every mode, and a copy of it shows MIP without reading level 0.
TEST_F(ExtremeLevels, ofAStoreThatAlsoHasMeansAreDrawn) {
  pack("mean");
  run("pack synth:phantom,dims=128x120x112 -o all.zarr --chunk 16 --levels 3 --downsample "
      "max,mean,min");
  EXPECT_THAT(run("info all.zarr --levels"),
              AllOf(HasSubstr("means, spread: u8"), HasSubstr("3 levels of maxima beside them"),
                    HasSubstr("3 levels of minima beside them")));
  render("mean.zarr");
  const auto means = picture();
  EXPECT_EQ(render("all.zarr")["cut"]["values"], "means");
  EXPECT_EQ(picture(), means);
  for (const auto& [how, mode, values] :
       {std::tuple{"max", "mip", "maxima"}, {"min", "minip", "minima"}}) {
    pack(how);
    for (const char* const cut : {"", " --level 2", " --pixel-error 3"}) {
      const std::string option = std::string("--mode ") + mode + cut;
      SCOPED_TRACE(option);
      render(std::string(how) + ".zarr", option);
      const auto expected = picture();
      const json report = render("all.zarr", option);
      EXPECT_EQ(report["cut"]["values"], values);
      EXPECT_EQ(picture(), expected);
    }
  }
  spoilLevelZero("all.zarr");
  fs::remove_all(program_.folder / "cache");
  EXPECT_EQ(render("all.zarr", "--mode mip")["volume"]["values_level"], 1);
  EXPECT_EQ(fs::exists(program_.folder / "all.zarr/maximum/1/.zarray"), true);
}

// Levels that hold something else are not drawn; those that a picture needs are made beside the
// index, and equal those of a store that was packed with them.
TEST_F(ExtremeLevels, areMadeBesideTheIndexOfStoresOfMeansAndOfFiles) {
  constexpr const char* kMade = " once and keeps ";
  pack("mean");
  pack("max");
  render("max.zarr", "--mode mip --level 1");
  const auto expected = picture();
  run("synth phantom --dims 128,120,112 -o v_128x120x112_uint8.raw");
  for (const std::string volume : {"mean.zarr", "v_128x120x112_uint8.raw"}) {
    SCOPED_TRACE(volume);
    const std::string picture_of = "render " + volume + " --mode mip --size 64 -o y.png --force ";
    EXPECT_THAT(run(picture_of), Not(HasSubstr(kMade)));
    EXPECT_THAT(run(picture_of + "--pixel-error 1 --levels always"), HasSubstr(kMade));
    EXPECT_THAT(run(picture_of + "--pixel-error 1 --levels always"), Not(HasSubstr(kMade)));
    // Later pictures use them without being asked to.
    EXPECT_EQ(render(volume, "--mode mip")["cut"]["values"], "maxima");
    render(volume, "--mode mip --level 1");
    EXPECT_LE(meanDifference(expected, picture()), 0.01);
  }
  // Other pictures of the store go on with its own.
  EXPECT_EQ(render("mean.zarr")["cut"]["values"], "means");
}

TEST_F(ExtremeLevels, ofDamagedGroupsAreMadeOfLevelZero) {
  run("synth phantom --dims 128,120,112 -o v_128x120x112_uint8.raw");
  const auto draw = [&] {
    return run(
        "render v_128x120x112_uint8.raw --mode mip --pixel-error 1 --size 64 -o x.png "
        "--force --levels always");
  };
  draw();
  const auto shown = picture();
  fs::path chunk;
  for (const auto& entry : fs::recursive_directory_iterator(program_.folder / "cache"))
    if (entry.is_regular_file() && entry.path().string().find(".zarr/0/") != std::string::npos &&
        entry.path().filename().string().front() != '.')
      chunk = entry.path();
  ASSERT_FALSE(chunk.empty());
  writeFile(chunk, "spoilt");
  EXPECT_THAT(draw(), HasSubstr("what is damaged is made of level 0"));
  EXPECT_EQ(picture(), shown);
}

TEST_F(ExtremeLevels, labelsAreDrawnFromTheMostFrequentOnes) {
  std::string labels;
  for (int z = 0; z < 64; ++z)
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        labels += static_cast<char>(z < 10 || x < 12 ? 0 : (y / 20 + 1) * 20);
  writeFile(program_.folder / "l_64x64x64_uint8.raw", labels);
  run("pack l_64x64x64_uint8.raw -o l.zarr --chunk 16 --levels 2 --downsample mode");
  const std::string look =
      "render l.zarr --labels --no-shade --block 16 --size 32 --view plain -o x.png --force ";
  const json report = program_.json(look);
  EXPECT_EQ(report["cut"]["values"], "modes");
  EXPECT_GE(report["cut"]["levels"][0]["level"], 1);
  const auto coarse = picture();
  program_.json(look + "--level 0");
  // A mean of two labels would be a third one of another colour.
  EXPECT_LT(meanDifference(coarse, picture()), 4);
}

// Plates of one voxel fill half of the voxels of level 1 that have their label, and a quarter of
// those of level 2 that do.
TEST_F(ExtremeLevels, thinLabelsDoNotGrow) {
  std::string labels;
  for (int z = 0; z < 64; ++z)
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        labels += static_cast<char>(z % 8 == 3 ? 20 : z % 4 == 1 ? 30 : 40);
  writeFile(program_.folder / "l_64x64x64_uint8.raw", labels);
  run("pack l_64x64x64_uint8.raw -o l.zarr --chunk 16 --levels 2 --downsample mode");
  EXPECT_THAT(run("info l.zarr --levels"), HasSubstr("modes, share: u8"));
  // The opacity of label 20 alone.
  const auto opacity = [&](const std::string& more) {
    const json report = program_.json(
        "render l.zarr --labels --label all=:0 --label 20=ffffff:0.2 --background 000000 "
        "--no-shade --block 16 --size 64 --view plain --azimuth 30 --fit volume -o x.png --force " +
        more);
    if (report.contains("cut")) {
      EXPECT_EQ(report["cut"]["spreads"], true);
    }
    const auto rgba = picture();
    double sum = 0;
    for (size_t i = 0; i < rgba.size(); i += 4) sum += rgba[i];
    return sum;
  };
  const double fine = opacity("--level 0");
  EXPECT_GT(fine, 0);
  EXPECT_NEAR(opacity("--level 1") / fine, 1, 0.1);
}

// The greatest value of a coarse voxel may be hidden while others of its voxels show.
TEST_F(ExtremeLevels, areNotDrawnIfTheLookHidesExtremesOfWhatItShows) {
  pack("max");
  const std::string band = " --mode mip --opacities 0:0,40:0,50:1,90:1,100:0";
  const std::string above = " --mode mip --opacities 40:0,50:1";
  const auto shows = [&](const std::string& look) {
    return program_
        .json(
            "render max.zarr --map grey --range 0,255 --no-shade --view plain --fit volume "
            "--block 16 -o x.png --force --size 64" +
            look)
        .contains("cut");
  };
  EXPECT_TRUE(shows(above));
  EXPECT_FALSE(shows(band));
  const auto drawn = picture();
  EXPECT_FALSE(shows(band + " --level 0"));
  EXPECT_EQ(picture(), drawn);
  const CommandResult refused = program_.run("render max.zarr -o y.png --size 32 --level 1" + band);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("hold maxima, and the look hides some of them"));
  pack("min");
  const std::string least = "plan min.zarr --size 64 --block 16 --mode minip";
  EXPECT_TRUE(program_.json(least).contains("cut"));
  EXPECT_FALSE(program_.json(least + " --threshold 40").contains("cut"));
}

// If a value falls as the stored number rises, the greatest value has the least number.
TEST_F(ExtremeLevels, ofNegatedValuesAreTheOtherExtremes) {
  run("synth phantom --dims 96,90,84 -o v_96x90x84_uint8.raw");
  const auto packed = [&](const std::string& name, const std::string& how) {
    run("pack v_96x90x84_uint8.raw -o " + name + " --chunk 16 --levels 2 --downsample " + how);
    std::string attributes = readFile(program_.folder / name / ".zattrs");
    const std::string key = "\"sluice\": {";
    const size_t at = attributes.find(key);
    ASSERT_NE(at, std::string::npos);
    attributes.insert(at + key.size(), "\"value_scale\": -1.0, \"value_offset\": 255.0,");
    writeFile(program_.folder / name / ".zattrs", attributes);
  };
  packed("both.zarr", "mean,max,min");
  packed("max.zarr", "max");
  for (const auto& [mode, values] : {std::pair{"mip", "minima"}, {"minip", "maxima"}}) {
    SCOPED_TRACE(mode);
    const std::string option = std::string("--mode ") + mode;
    EXPECT_EQ(render("both.zarr", option)["cut"]["values"], values);
    const auto coarse = picture();
    EXPECT_FALSE(render("both.zarr", option + " --level 0").contains("cut"));
    EXPECT_LT(meanDifference(coarse, picture()), 5);
  }
  EXPECT_FALSE(render("max.zarr", "--mode mip").contains("cut"));
}

TEST_F(ExtremeLevels, whatTheyDoNotShowIsRefusedInOneLine) {
  pack("max");
  const CommandResult refused = program_.run("render max.zarr --size 32 -o y.png --pixel-error 1");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("hold maxima, which are no means"));
  EXPECT_THAT(refused.output, HasSubstr("--downsample mean"));
  EXPECT_FALSE(render("max.zarr").contains("cut"));
}

}  // namespace
}  // namespace sluice
