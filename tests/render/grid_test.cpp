// Grids: spacing, origin, orientation, mirrored and oblique axes, awkward dimensions. An asymmetric
// volume, so that a swapped or mirrored axis cannot hide.
#include <gtest/gtest.h>

#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"
#include "tests/render/render_scene.h"

namespace sluice::grid_test {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;

// Brighter along x, then y, then z, and a hole in one corner.
std::unique_ptr<MemorySource> asymmetric(const VolumeLayout& layout) {
  const Vec3d outer = toDouble(layout.dims);
  return makeMemorySource<uint8_t>(layout, [&](int64_t x, int64_t y, int64_t z) {
    const Vec3d p = toDouble({x, y, z}) / outer;
    if (p.x < 0.5 && p.y < 0.3 && p.z < 0.4) return 0.0;
    return 30 + 120 * p.x + 60 * p.y + 30 * p.z;
  });
}

VolumeLayout layoutOf(Vec3i dims) {
  VolumeLayout layout;
  layout.dims = dims;
  return layout;
}

TransferFunction rainbow() {
  return {{{0, {0, 0, 1}}, {90, {0, 1, 0}}, {160, {1, 0, 0}}, {240, {1, 1, 1}}},
          {{20, 0}, {80, 0.05}, {240, 0.15}},
          "rainbow"};
}

class GridTest : public RenderTest {
 protected:
  void expectRightPictures(const VolumeLayout& layout, const std::string& what) {
    const auto source = asymmetric(layout);
    for (const bool lit : {false, true}) {
      RenderScene scene(device(), *source, rainbow(), {.block_vox = 16, .lit = lit});
      for (const Projection projection : {Projection::kOrtho, Projection::kPerspective}) {
        SCOPED_TRACE(
            fmt::format("{}, lit {}, projection {}", what, lit, static_cast<int>(projection)));
        FrameOptions options = obliqueView(projection, {64, 60});
        options.with_depth = true;
        const FloatPicture drawn = scene.draw(options), reference = scene.reference(options);
        EXPECT_GT(shownShare(drawn), 0.02);
        EXPECT_TRUE(within(kOfReference, drawn, reference));
        EXPECT_TRUE(depthsWithin(0.02 * finestSpacing(layout), drawn, reference));
        options.algorithm = Algorithm::kConventional;
        EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
      }
    }
  }
};

TEST_F(GridTest, anisotropicSpacing) {
  for (const Vec3d spacing :
       {Vec3d{1, 1, 2}, {0.3, 0.7, 1.1}, {5, 1, 1}, {1e-4, 2e-4, 1.5e-4}, {2e3, 1e3, 3e3}}) {
    VolumeLayout layout = layoutOf({30, 28, 26});
    layout.spacing = spacing;
    expectRightPictures(layout, fmt::format("{} {} {}", spacing.x, spacing.y, spacing.z));
  }
}

TEST_F(GridTest, originFarFromZero) {
  VolumeLayout layout = layoutOf({30, 28, 26});
  for (const Vec3d origin : {Vec3d{-100, 50, 20}, {1e6, -1e6, 5e5}}) {
    layout.origin = origin;
    expectRightPictures(layout, fmt::format("origin {}", origin.x));
  }
}

TEST_F(GridTest, orientedAxes) {
  VolumeLayout layout = layoutOf({30, 28, 26});
  layout.spacing = {1, 1.2, 0.8};
  // A rotation by a quarter and by no round angle.
  layout.axes = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  expectRightPictures(layout, "cyclic");
  layout.axes = {{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}};
  expectRightPictures(layout, "turned");
}

TEST_F(GridTest, mirroredAxes) {
  VolumeLayout layout = layoutOf({30, 28, 26});
  layout.axes = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  expectRightPictures(layout, "x flipped");
  layout.axes = {{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}};
  expectRightPictures(layout, "x and y swapped");
  layout.axes = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
  expectRightPictures(layout, "all flipped");
}

TEST_F(GridTest, obliqueAxes) {
  VolumeLayout layout = layoutOf({30, 28, 26});
  layout.axes = {{{1, 0, 0}, {0.6, 0.8, 0}, {0, 0.6, 0.8}}};
  expectRightPictures(layout, "oblique");
}

TEST_F(GridTest, dimensionsThatDoNotFillBlocks) {
  // Blocks of 16 own 15 cells: one voxel short of, exactly, and one over two blocks.
  for (const Vec3i dims : {Vec3i{30, 31, 32},
                           {16, 17, 15},
                           {46, 2, 33},
                           {2, 33, 17},
                           {33, 17, 2},
                           {2, 2, 2},
                           {2, 2, 40},
                           {70, 3, 2}})
    expectRightPictures(layoutOf(dims), fmt::format("{} {} {}", dims.x, dims.y, dims.z));
}

TEST_F(GridTest, volumeOfOneVoxelAlongAnAxisIsRefused) {
  EXPECT_THROW(blockLayout({5, 1, 5}, 8, 0), Error);
}

// A view of a mirrored grid is the mirror of the view, which no reference is needed for.
TEST_F(GridTest, mirroredGridGivesTheMirroredPicture) {
  VolumeLayout layout = layoutOf({30, 28, 26}), mirrored = layout;
  mirrored.axes[0] = {-1, 0, 0};
  const auto a = asymmetric(layout), b = asymmetric(mirrored);
  RenderScene scene(device(), *a, rainbow()), mirror(device(), *b, rainbow());
  FrameOptions options = obliqueView(Projection::kPerspective, {64, 64});
  options.camera.azimuth_deg = 25;
  const FloatPicture straight = scene.draw(options);
  options.camera.azimuth_deg = -25;
  FloatPicture turned = mirror.draw(options);
  for (int y = 0; y < turned.height; ++y)
    for (int x = 0; x < turned.width / 2; ++x)
      std::swap_ranges(turned.rgba.begin() + 4 * (y * turned.width + x),
                       turned.rgba.begin() + 4 * (y * turned.width + x) + 4,
                       turned.rgba.begin() + 4 * (y * turned.width + turned.width - 1 - x));
  EXPECT_TRUE(within(1, straight, turned));
  EXPECT_FALSE(within(20, straight, mirror.draw(options))) << "the volume is symmetric";
}

}  // namespace
}  // namespace sluice::grid_test
