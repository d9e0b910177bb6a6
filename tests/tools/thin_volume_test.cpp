// Volumes of one voxel along an axis are drawn one voxel thick.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "src/base/values/vec.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

constexpr int64_t kThinSide = 30;

// A disc in a plane, `planes` times along axis `axis`.
void writeDisc(const Program& program, const std::string& name, int axis, int64_t planes) {
  Vec3i dims{kThinSide, kThinSide, kThinSide};
  dims[axis] = planes;
  std::string bytes;
  for (int64_t z = 0; z < dims.z; ++z)
    for (int64_t y = 0; y < dims.y; ++y)
      for (int64_t x = 0; x < dims.x; ++x) {
        Vec3i p{x, y, z};
        p[axis] = kThinSide / 2;
        const double r = length(toDouble(p) - Vec3d{15, 15, 15});
        bytes += static_cast<char>(std::lround(200 * std::clamp((12 - r) / 3, 0.0, 1.0)));
      }
  writeFile(program.folder / fmt::format("{}_{}x{}x{}_uint8.raw", name, dims.x, dims.y, dims.z),
            bytes);
}

TEST(ThinVolume, isDrawnAsTwoPlanesAVoxelApart) {
  const Program program;
  for (int axis = 0; axis < 3; ++axis) {
    writeDisc(program, "thin", axis, 1);
    writeDisc(program, "two", axis, 2);
    Vec3i thin{kThinSide, kThinSide, kThinSide}, two = thin;
    thin[axis] = 1;
    two[axis] = 2;
    for (const char* mode : {"composite", "mip", "minip", "average"})
      for (const char* view : {"front", "three-quarter"}) {
        const auto draw = [&](const char* name, Vec3i dims) {
          return program.json(fmt::format(
              "render {}_{}x{}x{}_uint8.raw -o {}.exr --force --size 48x48 --threshold 80 "
              "--mode {} --view {}",
              name, dims.x, dims.y, dims.z, name, mode, view));
        };
        const auto report = draw("thin", thin);
        draw("two", two);
        const ExrContents one = readExr(program.folder / "thin.exr");
        const ExrContents other = readExr(program.folder / "two.exr");
        ASSERT_EQ(one.picture.rgba.size(), other.picture.rgba.size());
        double most = 0, shown = 0;
        for (size_t i = 0; i < one.picture.rgba.size(); ++i) {
          most = std::max<double>(most, std::abs(one.picture.rgba[i] - other.picture.rgba[i]));
          shown = std::max<double>(shown, one.picture.rgba[i]);
        }
        EXPECT_LT(most, 1.0 / 255) << axis << " " << mode << " " << view;
        EXPECT_GT(shown, 2.0 / 255) << axis << " " << mode << " " << view;
      }
  }
}

TEST(ThinVolume, isWhatItIsInInfoAndSaysHowItIsDrawn) {
  const Program program;
  writeDisc(program, "thin", 2, 1);
  const auto info = program.json("info thin_30x30x1_uint8.raw");
  EXPECT_EQ(info["dims"], nlohmann::json({30, 30, 1}));
  EXPECT_EQ(info["origin"], nlohmann::json({0, 0, 0}));
  EXPECT_EQ(info["bounds"], nlohmann::json({{0, 0, -0.5}, {29, 29, 0.5}}));
  const CommandResult result = program.run("render thin_30x30x1_uint8.raw -o a.png --size 40x40");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("one voxel along z, drawn one voxel thick"));
  EXPECT_THAT(result.output, HasSubstr("30 x 30 x 1 u8"));
  const CommandResult along_x = program.run("render synth:cube,dims=1x16x16 -o x.png --size 16");
  EXPECT_EQ(along_x.status, 0) << along_x.output;
  EXPECT_THAT(along_x.output, HasSubstr("1 x 16 x 16 u8"));
  EXPECT_EQ(program.run("render thin_30x30x1_uint8.raw -o b.png --size 40x40 --verify").status, 0);
}

TEST(ThinVolume, aSingleVoxelIsACube) {
  const Program program;
  writeFile(program.folder / "one_1x1x1_uint8.raw", std::string(1, '\x50'));
  const auto report =
      program.json("render one_1x1x1_uint8.raw -o a.png --size 40x40 --opacities 0:0.5,255:0.5");
  EXPECT_EQ(report["frames"][0]["empty"], "");
  const Rgba8Picture picture = readPng(program.folder / "a.png");
  EXPECT_GT(picture.rgba[4 * (20 * 40 + 20) + 3], 60);
}

// The crop may say more planes than the volume has.
TEST(CropOfOnePlane, mayReachBeyondTheVolume) {
  const Program program;
  const auto draw = [&](const std::string& box) {
    const std::string line = "render synth:phantom,dims=24x24x24 --no-shade --size 40x40 --force ";
    const auto report = program.json(line + "-o a.png --crop " + box);
    EXPECT_TRUE(report["warnings"].empty()) << report["warnings"];
    return readFile(program.folder / "a.png");
  };
  for (const auto& [inside, beyond] : {std::pair("23,0,0,24,24,24", "23,0,0,99,24,24"),
                                       {"0,23,0,24,24,24", "0,23,0,24,25,24"},
                                       {"0,0,23,24,24,24", "0,0,23,99,99,99"}})
    EXPECT_TRUE(draw(inside) == draw(beyond)) << beyond;
}

// The planes beside it are not shown, so that they do not frame the picture either.
TEST(CropOfOnePlane, isFramedWhateverLiesBesideIt) {
  const Program program;
  const auto draw = [&](const std::string& name, const std::vector<int>& full) {
    std::string bytes;
    for (int z = 0; z < kThinSide; ++z)
      for (int y = 0; y < kThinSide; ++y)
        for (int x = 0; x < kThinSide; ++x) {
          const bool is_spot = x / 4 == 3 && y / 4 == 3;
          bytes += static_cast<char>(std::ranges::count(full, z) > 0 || is_spot ? 200 : 0);
        }
    writeFile(program.folder / fmt::format("{0}_{1}x{1}x{1}_uint8.raw", name, kThinSide), bytes);
    const CommandResult drawn = program.run(fmt::format(
        "render {0}_{1}x{1}x{1}_uint8.raw -o {0}.png --crop 0,0,20,{1},{1},21 --threshold 100 "
        "--opacity 1 --no-shade --size 60x60",
        name, kThinSide));
    EXPECT_EQ(drawn.status, 0) << drawn.output;
    return readFile(program.folder / (name + ".png"));
  };
  const std::string alone = draw("alone", {});
  EXPECT_TRUE(draw("above", {21}) == alone);
  EXPECT_TRUE(draw("below", {19}) == alone);
}

}  // namespace
}  // namespace sluice
