#include "io/pictures/png_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/io/image_test_support.h"

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Rgba8Picture noise(int width, int height) {
  std::mt19937 random(4);
  Rgba8Picture picture{width, height,
                       std::vector<uint8_t>(static_cast<size_t>(width * height * 4))};
  for (auto& byte : picture.rgba) byte = static_cast<uint8_t>(random());
  return picture;
}

TEST(Picture, becomesStraightAlphaRoundedToNearest) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Picture picture{5,
                        1,
                        {0.25F,      0.5F,    0.125F, 0.5F,  // red 0.5, green 1, blue 0.25
                         0.4981F,    0.4979F, 2.0F,   1.0F,  // 127.02, 126.96, clamped
                         0,          0,       0,      0,     //
                         -1.0F,      kNan,    0.3F,   3.0F,  // clamped, not a number, straight 0.1
                         0.5F / 255, 0,       0,      0.0019F},  // alpha 0.48: rounds to 0
                        {}};
  EXPECT_THAT(toRgba8(picture).rgba, ElementsAre(128, 255, 64, 128, 127, 127, 255, 255, 0, 0, 0, 0,
                                                 0, 0, 26, 255, 255, 0, 0, 0));
}

TEST(Picture, overABackgroundIsOpaque) {
  const Picture picture{2, 1, {0.25F, 0, 0, 0.5F, 0, 0, 0, 0}, {7, 8}};
  const Picture result = over(picture, {1, 0.5F, 0});
  EXPECT_THAT(result.rgba, ElementsAre(0.75F, 0.25F, 0, 1, 1, 0.5F, 0, 1));
  EXPECT_EQ(result.depth, picture.depth);
}

// Values of the standard's table, by hand: 0.5 shown is 0.21404 of light.
TEST(Picture, inLinearLightHasTheTransferFunctionOfSrgbUndone) {
  const Picture picture{3, 1, {0.5F, 1, 0, 1, 0.25F, 0.5F, 0.01F, 0.5F, 0, 0, 0, 0}, {7, 8, 9}};
  const Picture linear = toLinearLight(picture);
  const float expected[] = {0.2140411F,         1,    0, 1, 0.1070206F, 0.5F,
                            0.02F / 12.92F / 2, 0.5F, 0, 0, 0,          0};
  for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(linear.rgba[i], expected[i], 1e-6F) << i;
  EXPECT_EQ(linear.depth, picture.depth);
}

TEST(PngFile, isTheSameHoweverItsRowsCome) {
  const TempFolder folder;
  const Rgba8Picture picture = noise(37, 23);
  writePng(folder / "whole.png", picture);
  for (const int step : {1, 5, 22}) {
    PngFile file(folder / "rows.png", 37, 23);
    for (int y = 0; y < 23; y += step) {
      const int count = std::min(step, 23 - y);
      Rgba8Picture rows{37, count, {}};
      rows.rgba.assign(picture.rgba.begin() + y * 37 * 4,
                       picture.rgba.begin() + (y + count) * 37 * 4);
      file.add(rows);
    }
    file.commit();
    EXPECT_EQ(readFile(folder / "rows.png"), readFile(folder / "whole.png")) << step;
  }
  { PngFile file(folder / "left.png", 37, 23); }
  EXPECT_FALSE(std::filesystem::exists(folder / "left.png"));
}

TEST(PngFile, comesBackAsWritten) {
  const TempFolder folder;
  const Rgba8Picture picture = noise(37, 23);
  writePng(folder / "a.png", picture);
  const Rgba8Picture read = readPng(folder / "a.png");
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 23);
  EXPECT_EQ(read.rgba, picture.rgba);
}

TEST(PngFile, isReadTheSameByVtk) {
  if (!hasPythonModules("vtkmodules.vtkIOImage")) GTEST_SKIP() << "python3 with VTK is missing";
  const TempFolder folder;
  const Rgba8Picture picture = noise(37, 23);
  writePng(folder / "a.png", picture);
  const auto run = runCommand(R"sh(/usr/bin/python3 -c "
import sys
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.util.numpy_support import vtk_to_numpy
r = vtkPNGReader(); r.SetFileName(sys.argv[1]); r.Update()
v = vtk_to_numpy(r.GetOutput().GetPointData().GetScalars())
assert v.shape == (37 * 23, 4)
v.reshape(23, 37, 4)[::-1].tofile(sys.argv[2])" )sh" +
                              (folder / "a.png").string() + " " + (folder / "a.bin").string());
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_EQ(readFile(folder / "a.bin"), std::string(picture.rgba.begin(), picture.rgba.end()));
}

TEST(PngFile, thatCannotBeWrittenIsAnErrorAndLeavesNothing) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { writePng(folder / "no" / "a.png", noise(3, 3)); }), HasSubstr("a.png"));
  std::filesystem::create_directory(folder / "b.png");
  EXPECT_THAT(errorOf([&] { writePng(folder / "b.png", noise(3, 3)); }), HasSubstr("b.png"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(PngFile, rejectsDamage) {
  const TempFolder folder;
  writePng(folder / "a.png", noise(37, 23));
  EXPECT_THAT(errorOf([&] { readPng(folder / "none.png"); }), HasSubstr("none.png"));
  const int accepted = surviveDamage(folder / "a.png", folder / "bad.png", 200, 0,
                                     [](const auto& path) { readPng(path); });
  EXPECT_LE(accepted, 1);  // the end mark may be missing
}

}  // namespace
}  // namespace sluice
