// A uniform translucent cube: no seam however many blocks it is cut into, and the opacity that can
// be worked out on paper, 1 - (1 - a)^(length / unit).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/render/render_scene.h"

namespace sluice {
namespace {

constexpr int64_t kCells = 70;  // 7 * 10: blocks of 8 voxels own 7 cells
constexpr double kOpacity = 0.02;
// Block sizes that cut 70 cells into 1, 2 and 10 blocks an axis.
constexpr struct { int64_t size, count; } kBlocks[] = {{128, 1}, {64, 8}, {8, 1000}};

TransferFunction translucent() {
  return {{{0, {1, 0.5, 0.25}}}, {{0, kOpacity}}, "translucent"};
}

std::unique_ptr<MemorySource> cube() {
  return makeMemorySource<uint8_t>(Vec3i{kCells + 1, kCells + 1, kCells + 1},
                                   [](auto...) { return 100; });
}

// How much of a ray lies in the cube, in units of `direction`.
double lengthInside(Vec3d start, Vec3d direction) {
  double from = 0, to = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double t0 = (0 - start[a]) / direction[a], t1 = (kCells - start[a]) / direction[a];
    from = std::max(from, std::min(t0, t1));
    to = std::min(to, std::max(t0, t1));
  }
  return std::max(0.0, to - from);
}

// Each pixel's opacity differs from the analytic one by at most one sample's: a path is rounded to
// whole steps.
void expectAnalyticOpacity(const FloatPicture& picture, const View& view) {
  for (int j = 0; j < picture.height; ++j)
    for (int i = 0; i < picture.width; ++i) {
      const double u = 2 * (i + 0.5) / picture.width - 1, v = 1 - 2 * (j + 0.5) / picture.height;
      const double aspect = static_cast<double>(picture.width) / picture.height;
      const Vec3d aside =
          view.right * (u * aspect * view.half_height) + view.up * (v * view.half_height);
      const bool ortho = view.projection == Projection::kOrtho;
      const Vec3d start = ortho ? view.eye + aside : view.eye;
      const Vec3d direction = ortho ? view.forward : view.forward + aside;
      const double path = lengthInside(start, direction) * length(direction);
      const double expected = 1 - std::pow(1 - kOpacity, path);
      const double one_sample = 1 - std::pow(1 - kOpacity, view.step * length(direction));
      ASSERT_NEAR(picture.at(i, j)[3], expected, one_sample + 1e-4) << i << ", " << j;
    }
}

class UniformCubeTest : public RenderTest {
 protected:
  void expectNoSeam(const FrameOptions& options, bool lit = false) {
    const auto source = cube();
    std::vector<FloatPicture> pictures;
    for (const auto& [size, count] : kBlocks) {
      RenderScene scene(device(), *source, translucent(),
                        {.block_vox = lit ? size * 2 : size, .lit = lit});
      const Frame frame = scene.frame(options);
      if (!lit) {
        EXPECT_EQ(frame.report.blocks.black, count);
      }
      pictures.push_back(scene.draw(options));
    }
    EXPECT_GT(shownShare(pictures[0]), 0.2);
    EXPECT_TRUE(within(1, pictures[0], pictures[1]));
    EXPECT_TRUE(within(1, pictures[0], pictures[2]));
    if (!lit)
      for (const FloatPicture& picture : pictures)
        expectAnalyticOpacity(picture, resolve(options, source->layout()));
  }
};

TEST_F(UniformCubeTest, orthographic) {
  expectNoSeam(obliqueView(Projection::kOrtho, {128, 128}));
}

TEST_F(UniformCubeTest, perspective) {
  expectNoSeam(obliqueView(Projection::kPerspective, {128, 128}));
}

TEST_F(UniformCubeTest, fineAndCoarseSteps) {
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const double step : {0.25, 3.7}) {
      SCOPED_TRACE(step);
      FrameOptions options = obliqueView(projection, {80, 80});
      options.step_vox = step;
      expectNoSeam(options);
    }
}

TEST_F(UniformCubeTest, fromWithin) {
  const auto source = cube();
  FrameOptions options = insideView(source->layout(), {0.4, 0.5, 0.6}, {0.9, 0.4, 0.2});
  expectNoSeam(options);
  options.step_vox = 0.25;
  expectNoSeam(options);
}

TEST_F(UniformCubeTest, lit) {
  expectNoSeam(obliqueView(Projection::kPerspective), true);
}

// Rays of whole length: nothing is left to the rounding of a path to steps.
TEST_F(UniformCubeTest, straightViewIsAnalyticToAHundredthOfALevel) {
  const auto source = cube();
  for (const auto& [size, count] : kBlocks)
    for (const double azimuth : {0, 90, 180, 270})
      for (const double step : {0.25, 0.5, 1.0, 2.0}) {
        RenderScene scene(device(), *source, translucent(), {.block_vox = size});
        FrameOptions options;
        options.camera.azimuth_deg = azimuth;
        options.camera.zoom = 2.2;  // the cube covers the picture
        options.size = {48, 40};
        options.step_vox = step;
        const FloatPicture picture = scene.draw(options);
        const double opacity = 1 - std::pow(1 - kOpacity, kCells);
        for (size_t pixel = 0; pixel < picture.rgba.size() / 4; ++pixel) {
          const std::array expected = {opacity, 0.5 * opacity, 0.25 * opacity, opacity};
          for (size_t c = 0; c < 4; ++c)
            ASSERT_NEAR(picture.rgba[4 * pixel + c], expected[c], 0.01 / 255)
                << count << " blocks, azimuth " << azimuth << ", step " << step << ", pixel "
                << pixel;
        }
      }
}

}  // namespace
}  // namespace sluice
