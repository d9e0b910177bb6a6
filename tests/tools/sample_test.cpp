// First pictures of volumes that have neither levels nor an index: from a part of their voxels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSampledView =
    " --opacity 0.1 --no-shade --view plain --fit volume --azimuth 30 --size 64 --force ";
constexpr const char* kBytes = " --threshold 60 --range 0,255 ";

class FirstPicture : public testing::Test {
 protected:
  void synth(const std::string& file, const std::string& more = "") const {
    const CommandResult result =
        program_.run("synth shells -q --dims 160x150x140 -o " + file + " " + more);
    ASSERT_EQ(result.status, 0) << result.output;
  }
  // The time is over before the first slice is read: nothing is read but the first round of slices.
  json render(const std::string& volume, const std::string& more = "--time-limit 0",
              const std::string& look = kBytes) const {
    return program_.json("render " + volume + " -o x.png" + kSampledView + look + more);
  }
  Rgba8Picture picture(const std::string& name = "x.png") const {
    return readPng(program_.folder / name);
  }
  // The mean difference of a picture from the one at level 0.
  double meanErrorOf(const Rgba8Picture& drawn, const std::string& volume,
                     const std::string& look = kBytes) const {
    const CommandResult whole = program_.run("render " + volume + " -o whole.png" + kSampledView +
                                             look + "--level 0 --index-dir elsewhere");
    EXPECT_EQ(whole.status, 0) << whole.output;
    const Rgba8Picture truth = picture("whole.png");
    double sum = 0;
    for (size_t i = 0; i < truth.rgba.size(); ++i) sum += std::abs(truth.rgba[i] - drawn.rgba[i]);
    return sum / static_cast<double>(truth.rgba.size());
  }
  void expectSampled(const json& report, const std::string& part) const {
    EXPECT_EQ(report["volume"]["sample"], part);
    EXPECT_EQ(report["volume"]["values_level"], 1);
    EXPECT_EQ(report["volume"]["index"]["state"], "not made");
    EXPECT_EQ(report["cut"]["final"], false);
    EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
    EXPECT_EQ(report["frames"][0]["missing_share"], 0.0) << "whole";
  }

  const Program program_;
};

TEST_F(FirstPicture, readsSlicesThatAreSpreadEvenly) {
  synth("v_160x150x140_uint8.raw");
  const json report = render("v_160x150x140_uint8.raw");
  expectSampled(report, "18 of 140 slices");
  EXPECT_EQ(report["levels"]["disk"]["read_bytes"], 18 * 160 * 150);
  EXPECT_LT(meanErrorOf(picture(), "v_160x150x140_uint8.raw"), 8);
  EXPECT_EQ(render("v_160x150x140_uint8.raw")["volume"]["index"]["state"], "not made")
      << "nothing of a sample is kept";
}

TEST_F(FirstPicture, isDrawnOfVoxelsOfAnyWidth) {
  synth("w.nrrd", "--type u16");
  synth("f.mhd", "--type f32");
  for (const char* name : {"w.nrrd", "f.mhd"}) {
    const std::string look = name == std::string("w.nrrd") ? " --threshold 15000 --range 0,65535 "
                                                           : " --threshold 0.24 --range 0,1 ";
    expectSampled(render(name, "--time-limit 0", look), "18 of 140 slices");
    EXPECT_LT(meanErrorOf(picture(), name, look), 8) << name;
  }
}

TEST_F(FirstPicture, saysThatItWillImprove) {
  synth("v_160x150x140_uint8.raw");
  const std::string said = program_
                               .run("render v_160x150x140_uint8.raw -o x.png --time-limit 0" +
                                    std::string(kSampledView) + kBytes)
                               .output;
  EXPECT_THAT(said, HasSubstr("18 of 140 slices were read, evenly spread"));
  EXPECT_THAT(said, HasSubstr("1 picture, the last after"));
  EXPECT_THAT(said, HasSubstr("level 1, will improve"));
}

TEST_F(FirstPicture, waitsForThePassIfThereIsTime) {
  synth("v_160x150x140_uint8.raw");
  const json whole = render("v_160x150x140_uint8.raw", "--time-limit 100s");
  EXPECT_EQ(whole["volume"]["sample"], nullptr);
  EXPECT_EQ(whole["volume"]["index"]["state"], "built");
  EXPECT_EQ(render("v_160x150x140_uint8.raw")["volume"]["sample"], nullptr)
      << "with an index, nothing is sampled";
}

TEST_F(FirstPicture, withoutLevelsIsNotSampled) {
  synth("v_160x150x140_uint8.raw");
  const json report = render("v_160x150x140_uint8.raw", "--time-limit 0 --levels none");
  EXPECT_EQ(report["volume"]["sample"], nullptr);
  EXPECT_EQ(report["volume"]["index"]["state"], "built");
}

TEST_F(FirstPicture, readsChunksThatAreSpreadEvenly) {
  synth("v.nrrd");
  const CommandResult packed = program_.run("pack v.nrrd -o v.zarr --chunk 16 -q");
  ASSERT_EQ(packed.status, 0) << packed.output;
  std::filesystem::remove_all(program_.folder / "cache");
  const json report = render("v.zarr");
  expectSampled(report, "125 of 900 chunks");
  EXPECT_LT(meanErrorOf(picture(), "v.zarr"), 12);
}

TEST_F(FirstPicture, ofOneCompressedStreamSaysThatAllOfItIsUnpacked) {
  synth("v_160x150x140_uint8.raw");
  ASSERT_EQ(program_.run("--version > version.txt && gzip -1 v_160x150x140_uint8.raw").status, 0);
  const std::string command = "render v_160x150x140_uint8.raw.gz -o x.png --time-limit 0" +
                              std::string(kSampledView) + kBytes;
  const std::string said = program_.run(command).output;
  EXPECT_THAT(said, HasSubstr("is one compressed stream, which cannot be read in parts"));
  EXPECT_THAT(said, HasSubstr("18 of 140 slices"));
}

TEST_F(FirstPicture, isFollowedByThePassAndBetterOnes) {
  synth("v_160x150x140_uint8.raw");
  // A row without a limit samples volumes that a pass of a second does not finish.
  ASSERT_EQ(
      program_.run("synth shells -q --dims 640x520x512 -o large_640x520x512_uint8.raw").status, 0);
  const json report =
      program_.json("render large_640x520x512_uint8.raw -o 'p_##.png' --progressive" +
                    std::string(kSampledView) + kBytes);
  const json& pictures = report["frames"][0]["pictures"];
  ASSERT_GE(pictures.size(), 2U);
  EXPECT_EQ(pictures[0]["cut"]["spreads"], false) << "a sample";
  EXPECT_EQ(pictures[0]["cut"]["final"], false);
  EXPECT_EQ(pictures[1]["cut"]["spreads"], true) << "levels";
  EXPECT_EQ(pictures.back()["cut"]["final"], true);
  EXPECT_EQ(report["volume"]["sample"], nullptr);
  EXPECT_EQ(report["volume"]["index"]["state"], "built");
  for (size_t i = 0; i < pictures.size(); ++i)
    EXPECT_TRUE(program_.exists("p_0" + std::to_string(i) + ".png"));
  EXPECT_FALSE(program_.exists("p_0" + std::to_string(pictures.size()) + ".png"));
}

}  // namespace
}  // namespace sluice
