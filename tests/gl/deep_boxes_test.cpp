#include "src/gl/deep_boxes.h"

#include <gtest/gtest.h>

#include <random>

#include "src/device/drawing_cost.h"
#include "src/render/camera/frame_setup.h"
#include "tests/device/draw_one_box.h"
#include "tests/gl/test_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

FrameSetup setupSeen(Projection projection, double azimuth_deg, double elevation_deg,
                     double step_vox) {
  VolumeLayout layout;
  layout.dims = {40, 30, 50};
  FrameOptions options;
  options.size = {30, 24};
  options.camera.projection = projection;
  options.camera.azimuth_deg = azimuth_deg;
  options.camera.elevation_deg = elevation_deg;
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{0, 0}, {255, 1}}, "ramp"};
  return frameSetup(resolve(options.camera, layout, options.size, step_vox), layout,
                    OpacityTable(transfer, map, {0, 255}), map, options);
}

// The slices at which a pixel's ray enters and leaves a box. The first number is the greater one if
// the ray misses the box.
std::pair<double, double> wayThrough(const FrameSetup& setup, const Box3& cells, Vec3d pixel) {
  const RayGrid& rays = setup.rays;
  const Vec3d origin = rays.origin0 + rays.origin_dx * pixel.x + rays.origin_dy * pixel.y;
  const Vec3d step = rays.step0 + rays.step_dx * pixel.x + rays.step_dy * pixel.y;
  double from = -1e30, to = 1e30;
  for (int a = 0; a < 3; ++a) {
    const double lo = (static_cast<double>(cells.lo[a]) - origin[a]) / step[a];
    const double hi = (static_cast<double>(cells.hi[a]) - origin[a]) / step[a];
    from = std::max(from, std::min(lo, hi));
    to = std::min(to, std::max(lo, hi));
  }
  return {from, to};
}

TEST(DeepBoxes, areCutIntoPartsThatEveryRayMeetsFromFrontToBack) {
  BoxDraw deep;
  deep.chunk = 7;
  deep.cells = {{3, 2, 5}, {39, 29, 45}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(-180, 180), tilt(-89, 89);
  for (int view = 0; view < 40; ++view) {
    const Projection projection = view % 2 == 0 ? Projection::kOrtho : Projection::kPerspective;
    const FrameSetup setup = setupSeen(projection, turn(random), tilt(random), 0.5);
    const std::vector<BoxDraw> parts = cutDeepBoxes(setup, std::span(&deep, 1), 30);
    ASSERT_GE(parts.size(), 4U);
    int64_t cells = 0;
    for (const BoxDraw& part : parts) {
      EXPECT_EQ(part.chunk, 7U);
      EXPECT_LE(slicesAcross(setup, part.cells), 30);
      EXPECT_TRUE(deep.cells.contains(part.cells));
      cells += part.cells.count();
    }
    EXPECT_EQ(cells, deep.cells.count());
    for (double y = 0.5; y < setup.size.height; y += 3)
      for (double x = 0.5; x < setup.size.width; x += 3) {
        double reached = -1e30;
        for (const BoxDraw& part : parts) {
          const auto [from, to] = wayThrough(setup, part.cells, {x, y, 0});
          if (from >= to) continue;
          EXPECT_GE(from, reached - 1e-9) << "view " << view << " pixel " << x << " " << y;
          reached = to;
        }
      }
  }
}

TEST(DeepBoxes, shallowOnesAndTheOrderOfAllStay) {
  const FrameSetup setup = setupSeen(Projection::kOrtho, 30, 20, 0.5);
  std::vector<BoxDraw> boxes(3);
  boxes[0].cells = {{0, 0, 0}, {4, 4, 4}};
  boxes[1].cells = {{0, 0, 0}, {1, 1, 49}};
  boxes[2].cells = {{5, 5, 5}, {9, 9, 9}};
  for (size_t i = 0; i < 3; ++i) boxes[i].chunk = i;
  const std::vector<BoxDraw> parts = cutDeepBoxes(setup, boxes, 60);
  ASSERT_EQ(parts.size(), 4U);
  EXPECT_EQ(parts[0].cells, boxes[0].cells);
  EXPECT_EQ(parts[1].chunk, 1U);
  EXPECT_EQ(parts[2].chunk, 1U);
  EXPECT_EQ(parts[3].cells, boxes[2].cells);
}

// Channels of a block are cut at the same planes; a part that a channel lacks is left out.
TEST(DeepBoxes, joinedOnesAreCutTogether) {
  const FrameSetup setup = setupSeen(Projection::kOrtho, 0, 0, 1);  // along -z
  std::vector<BoxDraw> joined(2);
  joined[0].cells = {{0, 0, 0}, {2, 2, 40}};
  joined[1].cells = {{0, 0, 30}, {2, 2, 40}};
  joined[1].channel = 1;
  joined[1].joins = true;
  const std::vector<BoxDraw> parts = cutDeepBoxes(setup, joined, 25);
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].cells, (Box3{{0, 0, 20}, {2, 2, 40}}));
  EXPECT_EQ(parts[1].cells, joined[1].cells);
  EXPECT_TRUE(parts[1].joins);
  EXPECT_EQ(parts[2].cells, (Box3{{0, 0, 0}, {2, 2, 20}}));
  EXPECT_FALSE(parts[2].joins);
}

// Lit labels take the most turns: of this box llvmpipe would leave the far half out.
TEST(DeepBoxes, ofLabelsAreDrawnToTheirFarEnd) {
  constexpr Vec3i kDims{16, 16, 64};
  std::vector<std::byte> labels(static_cast<size_t>(volume(kDims)));
  for (size_t i = 0; i < labels.size(); ++i)
    labels[i] = static_cast<std::byte>(1 + i / 7 % 3 + 3 * (i / (16 * 16 * 8)) % 4);
  VolumeLayout layout;
  layout.dims = kDims;
  FrameOptions options;
  options.size = {12, 12};
  options.step_vox = 0.04;
  TransferFunction transfer{{{0, {0.1, 0.3, 0.9}}, {6, {0.9, 0.9, 0.2}}, {12, {1, 0.6, 0.1}}},
                            {{0, 0.02}, {12, 0.02}},
                            "t"};
  transfer.labels = true;
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, {0, 12}), map, options);
  setup.lit = true;
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kDims - Vec3i{1, 1, 1});
  const ChunkTexelsPtr chunk = chunkTexels(kDims, DeviceType::kU8, labels);
  const auto device = testDevice();
  PlainDevice plain;
  const Picture drawn = drawOneBox(*device, setup, chunk, box);
  const Picture expected = drawOneBox(plain, setup, chunk, box);
  float worst = 0;
  for (size_t i = 0; i < drawn.rgba.size(); ++i)
    worst = std::max(worst, std::abs(drawn.rgba[i] - expected.rgba[i]));
  EXPECT_LT(worst, 2.0 / 255);
}

}  // namespace
}  // namespace sluice
