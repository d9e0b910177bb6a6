// Surfaces of volumes with levels of resolution as a user asks for them: which levels are drawn and
// read, the same picture in strips, and level 0 as of a volume without levels.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kIsoVolume = "synth:phantom,dims=160x140x120,levels=4 --block 32";
constexpr const char* kIsoLook = "--iso 90 --view plain --azimuth 30 --size 64";

class IsoLevels : public testing::Test {
 protected:
  json render(const std::string& more) const {
    return program_.json(
        fmt::format("render {} {} -o x.png --force {}", kIsoVolume, kIsoLook, more));
  }
  auto picture() const { return readPng(program_.folder / "x.png").rgba; }
  json plan(const std::string& more) const {
    return program_.json(fmt::format("plan {} {} {}", kIsoVolume, kIsoLook, more));
  }
  const Program program_;
};

TEST_F(IsoLevels, areDrawnFromTheLevelThatPixelsAskForAndPlanned) {
  for (const char* more : {"", "--level 2", "--pixel-error 4 --threshold 40 --opacity 0.02",
                           "--projection perspective --zoom 4 --pixel-error 3",
                           "--pixel-error 0.2 --max-bytes 400K"}) {
    SCOPED_TRACE(more);
    json drawn = render(more);
    json planned = plan(more);
    ASSERT_TRUE(drawn.contains("cut"));
    EXPECT_GT(drawn["cut"]["levels"][0]["blocks"], 0);
    for (json* report : {&drawn, &planned})
      for (const char* of_voxels : {"spread", "thin_blocks"})  // a plan reads no voxel
        (*report)["cut"].erase(of_voxels);
    EXPECT_EQ(planned["cut"], drawn["cut"]);
    EXPECT_EQ(planned["read"]["voxel_bytes"], drawn["frames"][0]["decoded_bytes"]);
  }
  const json drawn = render("");
  EXPECT_EQ(drawn["cut"]["levels"][0]["level"], 1);
  EXPECT_EQ(drawn["cut"]["coarse_share"], 1.0);
  const auto bytes = [&](const std::string& more) {
    return plan(more)["read"]["voxel_bytes"].get<uint64_t>();
  };
  EXPECT_LT(2 * bytes(""), bytes("--level 0"));
}

// A plan reads no voxels, which tell of bent and oblique sheets.
TEST_F(IsoLevels, refineWhatTheirVoxelsShowToBeLost) {
  const json coarse = render("--pixel-error 8");
  EXPECT_GT(coarse["cut"]["thin_blocks"], 0);
  for (const char* more : {"", "--device gl"}) {
    const json kept = render(fmt::format("--pixel-error 8 --keep-thin {}", more));
    EXPECT_EQ(kept["cut"]["thin_blocks"], 0) << more;
    EXPECT_LT(kept["cut"]["coarse_share"], 1) << more;
  }
  // Pictures with a time limit do not wait for them, and say so.
  EXPECT_GT(render("--pixel-error 8 --keep-thin --progressive")["cut"]["thin_blocks"], 0);
  const json planned = plan("--pixel-error 8 --keep-thin");
  EXPECT_EQ(planned["cut"]["coarse_share"], 1);
}

TEST_F(IsoLevels, levelZeroIsThePictureOfTheVolumeWithoutLevels) {
  EXPECT_FALSE(render("--level 0").contains("cut"));
  const auto leveled = picture();
  ASSERT_EQ(program_
                .run(fmt::format("render synth:phantom,dims=160x140x120 --block 32 {} -o plain.png",
                                 kIsoLook))
                .status,
            0);
  EXPECT_EQ(leveled, readPng(program_.folder / "plain.png").rgba);
}

TEST_F(IsoLevels, areTheSameInStrips) {
  const auto draw = [&](const char* memory) {
    const std::string options = fmt::format(
        "synth:phantom,dims=60x56x50,levels=3 --block 16 --page 16x16x16 --pages 64 --device cpu "
        "--iso 90 --pixel-error 20 --projection perspective --zoom 2 --size 901x777 --memory {}",
        memory);
    const json planned = program_.json("plan " + options);
    const json report = program_.json(fmt::format("render {} -o {}.png --force", options, memory));
    EXPECT_GE(report["cut"]["levels"].size(), 2U);
    EXPECT_LE(report["levels"]["volume_buffer"]["loads"], planned["most_read"]["blocks"]);
    return report["picture_memory_bytes"].get<uint64_t>();
  };
  EXPECT_LT(draw("24M"), draw("900M"));
  EXPECT_TRUE(readFile(program_.folder / "24M.png") == readFile(program_.folder / "900M.png"));
}

TEST_F(IsoLevels, comeInRowsOfPicturesFromCoarseToFine) {
  const json report = render("--progressive --pixel-error 0.5");
  const json& pictures = report["frames"][0]["pictures"];
  ASSERT_GE(pictures.size(), 2U);
  EXPECT_GT(pictures.front()["cut"]["levels"][0]["level"],
            pictures.back()["cut"]["levels"][0]["level"]);
  const auto last = picture();
  render("--pixel-error 0.5");
  EXPECT_EQ(picture(), last);
}

TEST_F(IsoLevels, lightsThemWithShadowsAtAnyLevel) {
  for (const char* light : {"--shadows", "--occlusion-light"})
    EXPECT_TRUE(render(fmt::format("--level 1 {}", light)).contains("cut"));
}

}  // namespace
}  // namespace sluice
