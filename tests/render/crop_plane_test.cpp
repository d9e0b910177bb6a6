// Crops of one voxel plane: the plane is drawn one voxel thick, with its values all through, as the
// same crop of a volume shows it whose planes are all alike.
#include <gtest/gtest.h>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"

namespace sluice::crop_plane_test {
namespace {

constexpr Vec3i kDims{34, 30, 26};

int64_t valueAt(int64_t x, int64_t y, int64_t z) {
  return 60 + 3 * x + 2 * y + ((x / 3 ^ y / 3 ^ z) & 1) * 60 - 2 * z;
}

VolumeLayout plainLayout() {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = {1, 1.25, 0.8};
  return layout;
}

// All planes along the axis have the values of `plane`. The two values of `range` lie far away from
// it: light depends on the range of all values.
std::unique_ptr<MemorySource> flatAlong(int axis, int64_t plane, const ValueRange& range) {
  const int64_t far = plane < kDims[axis] / 2 ? kDims[axis] - 1 : 0;
  return makeMemorySource<uint8_t>(plainLayout(), [=](int64_t x, int64_t y, int64_t z) {
    Vec3i at{x, y, z}, corner;
    corner[axis] = far;
    if (at == corner) return static_cast<int64_t>(range.lo);
    ++corner[(axis + 1) % 3];
    if (at == corner) return static_cast<int64_t>(range.hi);
    at[axis] = plane;
    return valueAt(at.x, at.y, at.z);
  });
}

struct Plane {
  int axis;
  int64_t plane;
};

class CropPlaneTest : public RenderTest {
 protected:
  CropPlaneTest() : source_(makeMemorySource<uint8_t>(plainLayout(), valueAt)) {}

  // Draws the plane of the volume and of a volume of such planes alone.
  void expectPlane(const Plane& at, FrameOptions options, const TransferFunction& transfer,
                   const SceneOptions& scene) {
    SCOPED_TRACE(fmt::format("axis {}, plane {}", at.axis, at.plane));
    options.crop = boxOf(kDims);
    options.crop->lo[at.axis] = at.plane;
    options.crop->hi[at.axis] = at.plane + 1;
    const FloatPicture drawn = RenderScene(device(), *source_, transfer, scene).draw(options);
    options.crop->lo[at.axis] = std::min(at.plane, kDims[at.axis] - 2);
    options.crop->hi[at.axis] = options.crop->lo[at.axis] + 2;
    const std::unique_ptr<MemorySource> flat = flatAlong(at.axis, at.plane, valueRangeOf(*source_));
    const FloatPicture right = RenderScene(device(), *flat, transfer, scene).draw(options);
    EXPECT_GT(shownShare(right), 0.05);
    EXPECT_TRUE(within(1, drawn, right));
  }
  void expectPlanes(const FrameOptions& options, const TransferFunction& transfer,
                    const SceneOptions& scene = {}) {
    for (const Plane& at : {Plane{2, 9}, {2, 0}, {2, 25}, {0, 16}, {1, 15}})
      expectPlane(at, options, transfer, scene);
  }

  std::unique_ptr<MemorySource> source_;
  TransferFunction transfer_ = thresholdTransfer(40, {0, 255}, 0.2, "viridis");
};

TEST_F(CropPlaneTest, allModesShowThePlaneAlone) {
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage,
                          Mode::kAttenuatedMip, Mode::kDepthMip})
    for (const Projection projection : kProjections) {
      SCOPED_TRACE(static_cast<int>(mode));
      FrameOptions options = obliqueView(projection, {64, 60});
      options.mode = mode;
      options.with_depth = mode == Mode::kComposite;
      expectPlanes(options, transfer_, {.block_vox = 8});
    }
}

TEST_F(CropPlaneTest, lightSeesNoNeighbours) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  expectPlanes(options, transfer_, {.lit = true});
  const TransferFunction opaque = thresholdTransfer(150, {0, 255}, 1, "viridis");
  options.lighting.shadows = 1;
  expectPlanes(options, opaque, {.lit = true});
  options.lighting.shadows = 0;
  options.lighting.occlusion = 1;
  expectPlanes(options, opaque, {.lit = true});
}

TEST_F(CropPlaneTest, integratedSamples) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.integrates = true;
  options.step_vox = 0.5;
  expectPlanes(options, transfer_, {.ghost = true});
}

// Cells of neighbouring planes, and those of crops with two planes, have chunks of the same voxels.
TEST_F(CropPlaneTest, planesAreToldApartInOneSession) {
  RenderScene scene(device(), *source_, transfer_);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  for (const Box3& crop :
       {Box3{{0, 0, 24}, {34, 30, 25}}, {{0, 0, 25}, {34, 30, 26}}, {{0, 0, 24}, {34, 30, 26}}}) {
    options.crop = crop;
    const FloatPicture drawn = scene.draw(options);
    EXPECT_TRUE(within(0.1, drawn, RenderScene(device(), *source_, transfer_).draw(options)));
  }
}

TEST_F(CropPlaneTest, surfacesAndLabels) {
  TransferFunction surfaces = transfer_;
  surfaces.surfaces = {{100, 0.6, {1, 0, 0}}, {150, 1, {1, 1, 0}}};
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  expectPlanes(options, surfaces, {.lit = true});
  options.lighting.shadows = 1;
  expectPlanes(options, surfaces, {.lit = true});
  TransferFunction labels = transfer_;
  labels.labels = true;
  expectPlanes(obliqueView(Projection::kOrtho, {64, 60}), labels);
}

TEST_F(CropPlaneTest, severalAxesAtOnce) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  RenderScene scene(device(), *source_, transfer_);
  options.crop = Box3{{7, 8, 9}, {8, 9, 10}};
  const FloatPicture voxel = scene.draw(options);
  EXPECT_GT(shownShare(voxel), 0);
  const std::unique_ptr<MemorySource> flat = makeMemorySource<uint8_t>(
      plainLayout(), [](int64_t, int64_t, int64_t) { return valueAt(7, 8, 9); });
  options.crop = Box3{{7, 8, 9}, {9, 10, 11}};
  EXPECT_TRUE(within(1, voxel, RenderScene(device(), *flat, transfer_).draw(options)));
}

}  // namespace
}  // namespace sluice::crop_plane_test
