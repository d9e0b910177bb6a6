// The opacity map and the marks of opaque pixels, against the picture that they are made from.
#include <gtest/gtest.h>

#include <cmath>

#include "src/base/error.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "src/render/frame/frame_occlusion.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr Vec3i kMapDims{24, 20, 28};
// A device may look at squares of so many pixels together.
constexpr int kMostPixelsAround = 4;

class OpacityMapTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    device_ = suiteDevice();
    // Spots of all opacities.
    std::vector<std::byte> texels(static_cast<size_t>(volume(kMapDims)));
    uint32_t state = 7;
    for (std::byte& texel : texels) {
      state = state * 1664525U + 1013904223U;
      texel = static_cast<std::byte>((state >> 24) > 200 ? state >> 16 & 255 : 0);
    }
    device_->makeResident(1, chunkTexels(kMapDims, DeviceType::kU8, texels));
  }
  static void TearDownTestSuite() { device_.reset(); }

  static inline std::unique_ptr<Device> device_;
};

struct Drawn {
  FrameSetup setup;
  EyePosition eye;
};

// Draws the whole volume seen so.
Drawn drawSeenBy(Device& device, const Camera& camera, double opacity) {
  VolumeLayout layout;
  layout.dims = kMapDims;
  layout.spacing = {1, 1.3, 0.8};
  FrameOptions options;
  options.camera = camera;
  options.size = {150, 130};
  const View view = resolve(camera, layout, options.size, 0.5);
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{10, 0}, {255, opacity}}, "spots"};
  Drawn drawn{frameSetup(view, layout, OpacityTable(transfer, map, {0, 255}), map, options),
              eyePosition(view, layout)};
  device.beginFrame(drawn.setup);
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kMapDims - Vec3i{1, 1, 1});
  device.draw({&box, 1});
  return drawn;
}

// The point at which the ray of a pixel (y upwards) meets the map, in cells of the grid.
std::optional<std::array<double, 2>> onMap(const MapGrid& grid, PictureSize size, int x, int y) {
  // Cramer's rule on the rows of (clip x - X w, clip y - Y w).
  const double cx = (x + 0.5) / size.width * 2 - 1, cy = (y + 0.5) / size.height * 2 - 1;
  std::array<std::array<double, 3>, 2> m{};
  for (size_t i = 0; i < 3; ++i) {
    m[0][i] = grid.clip_from_map[0][i] - cx * grid.clip_from_map[2][i];
    m[1][i] = grid.clip_from_map[1][i] - cy * grid.clip_from_map[2][i];
  }
  const double d = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  const std::array<double, 2> at = {(m[0][1] * m[1][2] - m[0][2] * m[1][1]) / d,
                                    (m[0][2] * m[1][0] - m[0][0] * m[1][2]) / d};
  const double w = grid.clip_from_map[2][0] * at[0] + grid.clip_from_map[2][1] * at[1] +
                   grid.clip_from_map[2][2];
  if (w <= 0) return std::nullopt;
  return at;
}

TEST_F(OpacityMapTest, aCellHoldsNoMoreThanTheLeastOfItsPixels) {
  std::vector<Camera> cameras(5);
  cameras[1].azimuth_deg = 35;
  cameras[1].elevation_deg = 25;
  cameras[2].azimuth_deg = -100;
  cameras[2].zoom = 3;
  cameras[3].projection = Projection::kPerspective;
  cameras[3].azimuth_deg = 40;
  cameras[3].elevation_deg = -50;
  cameras[4].projection = Projection::kPerspective;
  cameras[4].look_at = Camera::LookAt{{12, 15, 40}, {10, 12, 0}};
  cameras[4].up = Vec3d{0.3, 1, 0};
  for (size_t i = 0; i < cameras.size(); ++i) {
    SCOPED_TRACE(i);
    const Drawn drawn = drawSeenBy(*device_, cameras[i], 1);
    const Box3 cells = boxOf(kMapDims - Vec3i{1, 1, 1});
    const FrameOcclusion occlusion(Occlusion::kClip, drawn.setup, drawn.eye,
                                   {cells, cells.count(), 1});
    const MapGrid grid = occlusion.grid();
    const std::vector<float> least = device_->leastOpacity(grid);
    const Picture picture = device_->endFrame();
    const auto side = static_cast<size_t>(grid.side);
    // The least of the pixels whose rays meet the cell, and of those some way around it.
    std::vector<float> inside(side * side, 1), around(side * side, 1);
    const int reach = kMostPixelsAround + 1;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        const float opacity = picture.rgba[4 * (static_cast<size_t>(picture.height - 1 - y) *
                                                    static_cast<size_t>(picture.width) +
                                                static_cast<size_t>(x)) +
                                           3];
        // Into the cells within `reach` cells of the place where the ray meets the map.
        const auto put = [&](std::vector<float>& to, int px, int py, int reach_cells) {
          const auto at = onMap(grid, drawn.setup.size, px, py);
          if (!at) return;
          const double u = std::floor((*at)[0]), v = std::floor((*at)[1]);
          for (double cv = v - reach_cells; cv <= v + reach_cells; ++cv)
            for (double cu = u - reach_cells; cu <= u + reach_cells; ++cu) {
              if (cu < 0 || cv < 0 || cu >= grid.side || cv >= grid.side) continue;
              float& cell = to[static_cast<size_t>(cv) * side + static_cast<size_t>(cu)];
              cell = std::min(cell, opacity);
            }
        };
        put(inside, x, y, 0);
        for (int dy = -reach; dy <= reach; ++dy)
          for (int dx = -reach; dx <= reach; ++dx) put(around, x + dx, y + dy, 1);
      }
    int opaque = 0;
    for (size_t c = 0; c < least.size(); ++c) {
      EXPECT_LE(least[c], inside[c] + 1e-6F) << c % side << ' ' << c / side;
      EXPECT_GE(least[c], around[c] - 1e-6F) << c % side << ' ' << c / side;
      opaque += least[c] > 0 && inside[c] < 1 ? 1 : 0;
    }
    EXPECT_GT(opaque, 100) << "the map says something";
  }
}

TEST_F(OpacityMapTest, markedPixelsTakeNothingMore) {
  Camera camera;
  camera.azimuth_deg = 20;
  camera.elevation_deg = 10;
  const Drawn drawn = drawSeenBy(*device_, camera, 1);
  const Picture once = device_->endFrame();
  FrameSetup setup = drawn.setup;
  setup.opacity_threshold = 0.6;
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kMapDims - Vec3i{1, 1, 1});
  const auto drawTwice = [&](bool stops) {
    FrameSetup first = drawn.setup;
    first.opacity_threshold = setup.opacity_threshold;
    device_->beginFrame(first);
    device_->draw({&box, 1});
    if (stops) device_->stopOpaque();
    device_->draw({&box, 1});
    return device_->endFrame();
  };
  const Picture with = drawTwice(true), without = drawTwice(false);
  device_->beginFrame(setup);
  device_->draw({&box, 1});
  const Picture alone = device_->endFrame();
  int stopped = 0, others = 0;
  for (size_t i = 0; i < with.rgba.size(); i += 4) {
    const bool opaque = alone.rgba[i + 3] >= 0.6F;
    const Picture& expected = opaque ? alone : without;
    for (size_t channel = 0; channel < 4; ++channel)
      ASSERT_EQ(with.rgba[i + channel], expected.rgba[i + channel]);
    ++(opaque ? stopped : others);
  }
  EXPECT_GT(stopped, 500);
  EXPECT_GT(others, 500);
  // The next frame begins without marks.
  drawSeenBy(*device_, camera, 1);
  EXPECT_EQ(device_->endFrame().rgba, once.rgba);
}

}  // namespace
}  // namespace sluice
