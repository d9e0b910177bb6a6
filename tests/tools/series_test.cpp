// A series of OpenVDB files, as simulations leave them: a plume that grows from step to step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/pictures/exr_file.h"
#include "tests/support/vdb_writer.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

constexpr int kSteps = 5;

// Smoke that is dense in the middle and thin at its rim, `step` steps high; most of the box that
// all steps share is empty.
std::map<std::array<int, 3>, float> plume(int step) {
  std::map<std::array<int, 3>, float> points;
  const int height = 10 + 11 * step;
  for (int y = 0; y < height; ++y) {
    const double reach = 3 + 0.15 * y + (y > height - 8 ? 2 : 0);
    const double x0 = 3 * std::sin(y / 9.0), z0 = 3 * std::cos(y / 11.0);
    const int side = static_cast<int>(reach) + 4;
    for (int z = -side; z <= side; ++z)
      for (int x = -side; x <= side; ++x) {
        const double swirl =
            0.25 * std::sin(x * 1.1 + step) * std::sin(z * 0.9) * std::sin(y * 0.7);
        const double density = 1.1 - std::hypot(x - x0, z - z0) / reach + swirl;
        if (density > 0.02) points[{x, y, z}] = static_cast<float>(0.2 * density * (1 - 0.006 * y));
      }
  }
  return points;
}

// The visible pixels: the first and the last row, and the sum of opacities.
struct Shown {
  int top = -1, bottom = -1;
  double opacity = 0;
};

Shown shownIn(const Picture& picture) {
  Shown shown;
  const auto width = static_cast<size_t>(picture.width);
  for (int y = 0; y < picture.height; ++y)
    for (size_t x = 0; x < width; ++x) {
      const double alpha = picture.rgba[4 * (static_cast<size_t>(y) * width + x) + 3];
      shown.opacity += alpha;
      if (alpha < 0.2) continue;
      if (shown.top < 0) shown.top = y;
      shown.bottom = y;
    }
  return shown;
}

TEST(Series, aPlumeGrowsUnderOneLookAndOneCamera) {
  const Program program;
  for (int step = 0; step < kSteps; ++step)
    writePoints(program.folder / fmt::format("plume_{:03}.vdb", step), plume(step));
  std::string look, camera;
  Shown last;
  for (int step = 0; step < kSteps; ++step) {
    SCOPED_TRACE(step);
    const auto report =
        program.json(fmt::format("render plume_%03d.vdb --size 96 -o a.exr --time {}", step));
    const ExrContents exr = readExr(program.folder / "a.exr");
    const std::string options = report["look"]["options"];
    const auto attribute = std::find_if(exr.attributes.begin(), exr.attributes.end(),
                                        [](const auto& each) { return each.first == "camera"; });
    ASSERT_NE(attribute, exr.attributes.end());
    const Shown shown = shownIn(exr.picture);
    ASSERT_GE(shown.top, 0) << "nothing shows";
    if (step == 0) {
      look = options;
      camera = attribute->second;
      // Smoke, from its thinnest on: not the densest of it alone.
      EXPECT_THAT(report["look"]["name"].get<std::string>(), testing::HasSubstr("above 0.0"));
    } else {
      EXPECT_EQ(options, look);
      EXPECT_EQ(attribute->second, camera);
      EXPECT_LT(shown.top, last.top - 6);
      EXPECT_NEAR(shown.bottom, last.bottom, 2) << "it stands where it stood";
      EXPECT_GT(shown.opacity, 1.2 * last.opacity);
    }
    last = shown;
  }
  EXPECT_LT(last.top, 12) << "the last one fills the picture";
}

// They have no files beside hidden ones in their folders, of which the program made a crash.
TEST(Series, mayBeOfStores) {
  const Program program;
  for (const char* const step :
       {"synth:shells,dims=24x20x16 -o v_0.zarr", "synth:cube,dims=24x20x16 -o v_1.zarr"})
    ASSERT_EQ(program.run(std::string("pack -q ") + step).status, 0);
  const std::string view = " --size 32 --range 0,255 --threshold 60 --opacity 0.2 -q --force -o ";
  const CommandResult series = program.run("render v_0.zarr v_1.zarr --time 1" + view + "s.png");
  EXPECT_EQ(series.status, 0) << series.output;
  ASSERT_EQ(program.run("render v_1.zarr" + view + "one.png").status, 0);
  EXPECT_TRUE(readFile(program.folder / "s.png") == readFile(program.folder / "one.png"));
  // Their index knows each of them.
  ASSERT_EQ(program.run("pack -q --force synth:noise,dims=24x20x16 -o v_1.zarr").status, 0);
  ASSERT_EQ(program.run("render v_0.zarr v_1.zarr --time 1" + view + "s.png").status, 0);
  ASSERT_EQ(program.run("render v_1.zarr" + view + "one.png").status, 0);
  EXPECT_TRUE(readFile(program.folder / "s.png") == readFile(program.folder / "one.png"));
}

// The view is fitted to all steps, and the tables of the transfer function span the values of all.
TEST(Series, aStepAloneIsThatOfARange) {
  const Program program;
  for (const char* look : {"--range 0,1 --threshold 0.3", "--range 0,0.5 --opacities 0.1:0,0.4:0.2",
                           "--range 0,1 --threshold 0.3 --fit volume --depth-cueing", ""}) {
    const std::string render = fmt::format(
        "render synth:mixing,dims=40x40x40,type=f32,steps=4 --size 128 -q --force {} ", look);
    ASSERT_EQ(program.run(render + "--time 1 -o one.png").status, 0);
    ASSERT_EQ(program.run(render + "--time 1:2 -o s_%d.png").status, 0);
    EXPECT_TRUE(readFile(program.folder / "one.png") == readFile(program.folder / "s_1.png"))
        << look;
  }
}

TEST(Series, stepsAreCountedFromZeroWhateverTheFilesNumbers) {
  const Program program;
  for (int step = 1001; step <= 1003; ++step)
    writeFile(program.folder / fmt::format("s_{}_8x8x8_uint8.raw", step),
              std::string(512, static_cast<char>(step)));
  const std::string render = "render 's_####_8x8x8_uint8.raw' --size 16 -o a.png --time ";
  EXPECT_EQ(program.run(render + "2").status, 0);
  const CommandResult number = program.run(render + "1002");
  EXPECT_EQ(number.status, 1);
  EXPECT_THAT(
      number.output,
      testing::HasSubstr("--time 1002: time steps are counted from 0, not by the files' "
                         "numbers: the file of that number is step 1 of 3; give --time 1\n"));
  EXPECT_THAT(program.run(render + "1001:1003").output, testing::HasSubstr("is step 2 of 3"));
  EXPECT_THAT(program.run(render + "1001:1024").output,
              testing::HasSubstr("not by the files' numbers: the last file has number 1003 and is "
                                 "step 2 of 3; s_1004_8x8x8_uint8.raw is missing\n"));
  EXPECT_THAT(program.run(render + "3").output,
              testing::HasSubstr("s_1004_8x8x8_uint8.raw is missing"));
}

}  // namespace
}  // namespace sluice
