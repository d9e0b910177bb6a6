// Shadows and ambient occlusion: light that passes a slab, and a pit, against what can be computed
// by hand; pictures against the reference, for any blocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"
#include "src/render/light/arriving_light.h"
#include "src/render/light/light_sweep.h"
#include "tests/render/blob_scene.h"
#include "tests/render/right_picture.h"

namespace sluice {
namespace {

// Software GL against a renderer in double precision, and the 16 bits of a light volume.
constexpr double kOfLitReference = 2;

class LightTest : public RightPictureTest {};

Lighting lookingAround(double shadows, double occlusion) {
  Lighting lighting;
  lighting.shadows = shadows;
  lighting.occlusion = occlusion;
  return lighting;
}

// A texel is a voxel.
CoarseExtinction emptyMatter(Vec3i texels) {
  return {{texels, {1, 1, 1}}, std::vector<float>(static_cast<size_t>(volume(texels)), 0.0F)};
}
float& lightTexel(std::vector<float>& numbers, Vec3i texels, Vec3i texel) {
  return numbers[static_cast<size_t>((texel.z * texels.y + texel.y) * texels.x + texel.x)];
}

TEST_F(LightTest, aSlabLetsThroughWhatItsThicknessLeaves) {
  const Vec3i texels{20, 24, 28};
  WorkerPool pool(2);
  constexpr float kExtinction = 0.2F;
  for (int axis = 0; axis < 3; ++axis) {
    CoarseExtinction matter = emptyMatter(texels);
    Vec3i texel;
    for (texel.z = 0; texel.z < texels.z; ++texel.z)
      for (texel.y = 0; texel.y < texels.y; ++texel.y)
        for (texel.x = 0; texel.x < texels.x; ++texel.x)
          if (texel[axis] >= 8 && texel[axis] < 12)
            lightTexel(matter.per_length, texels, texel) = kExtinction;
    for (const bool from_above : {false, true})
      for (const double slant : {0.0, 0.6, 1.0}) {
        Vec3d toward;
        toward[axis] = from_above ? 1 : -1;
        toward[(axis + 1) % 3] = slant;
        const double stretched = std::sqrt(1 + slant * slant);
        std::vector<float> light(matter.per_length.size(), 0.0F);
        addLight(matter, {toward, stretched, 0}, 1, pool, light);
        // These lie in the middle, where nothing comes from beside the slab.
        Vec3i before{texels / Vec3i{2, 2, 2}}, behind = before;
        before[axis] = from_above ? 13 : 6;
        behind[axis] = from_above ? 6 : 13;
        SCOPED_TRACE(fmt::format("axis {} above {} slant {}", axis, from_above, slant));
        EXPECT_FLOAT_EQ(lightTexel(light, texels, before), 1);
        if (slant == 0)
          EXPECT_NEAR(lightTexel(light, texels, behind), std::exp(-4 * kExtinction), 1e-5);
        else  // from the slab's sides some light comes in
          EXPECT_NEAR(lightTexel(light, texels, behind), std::exp(-4 * kExtinction * stretched),
                      0.02);
      }
  }
}

TEST_F(LightTest, aShadowFallsWhereTheLightPointsTo) {
  const Vec3i texels{40, 9, 40};
  CoarseExtinction matter = emptyMatter(texels);
  for (int64_t y = 0; y < texels.y; ++y)
    for (int64_t x = 15; x < 25; ++x) lightTexel(matter.per_length, texels, {x, y, 35}) = 50;
  WorkerPool pool(2);
  std::vector<float> light(matter.per_length.size(), 0.0F);
  const Vec3d toward{0.5, 0, 1};  // half a texel to the side for each texel down
  addLight(matter, {toward, length(toward), 0}, 1, pool, light);
  // 20 texels below the plate its shadow has moved by 10; a texel looks at the light of the last.
  const auto below = [&](int64_t x) { return lightTexel(light, texels, {x, 4, 15}); };
  EXPECT_GT(below(0), 0.9);
  EXPECT_LT(below(10), 0.05);
  EXPECT_GT(below(20), 0.9);
  EXPECT_NEAR(below(5), 0.5, 0.2);  // its edges, at 15 - 10 and 25 - 10
  EXPECT_NEAR(below(15), 0.5, 0.2);
  EXPECT_FLOAT_EQ(lightTexel(light, texels, {20, 4, 39}), 1);
}

TEST_F(LightTest, aPitIsDarkerThanAPlain) {
  const Vec3i texels{40, 40, 40};
  CoarseExtinction matter = emptyMatter(texels);
  const auto isPit = [](Vec3i t) { return std::abs(t.x - 20) <= 1 && std::abs(t.y - 20) <= 1; };
  Vec3i texel;
  for (texel.z = 0; texel.z < 20; ++texel.z)
    for (texel.y = 0; texel.y < 40; ++texel.y)
      for (texel.x = 0; texel.x < 40; ++texel.x)
        if (!isPit(texel) || texel.z < 8) lightTexel(matter.per_length, texels, texel) = 20;
  const auto source = makeMemorySource<uint8_t>(texels, [&](int64_t x, int64_t y, int64_t z) {
    return lightTexel(matter.per_length, texels, {x, y, z}) > 0 ? 200 : 0;
  });
  RenderScene scene(device(), *source, thresholdTransfer(100, {0, 255}, 1, "grey"),
                    {.block_vox = 16, .lit = true});
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.lighting = lookingAround(0, 1);
  const auto look = std::make_shared<const Look>(makeLook(
      scene.step(), pointsTransfer("grey", {0, 255}, {{99, 0}, {100, 1}}), Mode::kComposite));
  ArrivingLight arriving;
  WorkerPool pool(2);
  const View view = resolve(options.camera, source->layout(), options.size, 1);
  const LightVolumePtr light =
      arriving.of(scene.step(), look, MatterFrom::kFinest, view, options, pool);
  ASSERT_NE(light, nullptr);
  EXPECT_EQ(light->dims, texels);
  const auto openAt = [&](Vec3i t) {
    return light->texels[2 * static_cast<size_t>((t.z * 40 + t.y) * 40 + t.x) + 1] / kAllLight;
  };
  EXPECT_GT(openAt({8, 8, 20}), 0.9) << "a plain sees half of all directions";
  EXPECT_DOUBLE_EQ(openAt({20, 20, 38}), 1);
  EXPECT_LT(openAt({20, 20, 8}), 0.65) << "the bottom of the pit";
  EXPECT_LT(openAt({20, 20, 8}), openAt({20, 20, 16}));
  EXPECT_LT(openAt({10, 10, 5}), 0.5) << "within the matter";
  // The key light is whole without shadows.
  EXPECT_EQ(light->texels[0], kAllLight);
  // The same frame has the same light, and other strengths have others.
  EXPECT_EQ(arriving.of(scene.step(), look, MatterFrom::kFinest, view, options, pool), light);
  options.lighting.occlusion = 0.5;
  EXPECT_NE(arriving.of(scene.step(), look, MatterFrom::kFinest, view, options, pool), light);
  options.lighting = {};
  EXPECT_EQ(arriving.of(scene.step(), look, MatterFrom::kFinest, view, options, pool), nullptr);
}

TEST_F(LightTest, picturesAreThoseOfTheReference) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32}) {
    const auto source = spacedBlobs(type);
    const ValueRange range = valueRangeOf(*source);
    const auto at = [&](double share) { return range.lo + share * (range.hi - range.lo); };
    const TransferFunction transfer =
        pointsTransfer("viridis", range, {{at(0.1), 0}, {at(0.3), 0.3}, {at(0.9), 0.8}});
    for (const Projection projection : kProjections)
      for (const Lighting& lighting :
           {lookingAround(1, 0), lookingAround(0, 1), lookingAround(0.7, 0.4)}) {
        SCOPED_TRACE(fmt::format("{}, projection {}, shadows {}, occlusion {}", name(type),
                                 static_cast<int>(projection), lighting.shadows,
                                 lighting.occlusion));
        FrameOptions options = obliqueView(projection, {64, 60});
        options.lighting = lighting;
        expectRightPicture(*source, transfer, options, options, true);
      }
  }
}

TEST_F(LightTest, surfacesAndSegmentsAreInShadowToo) {
  const auto source = spacedBlobs(VoxelType::kU8);
  const ValueRange range = valueRangeOf(*source);
  TransferFunction transfer = pointsTransfer(
      "viridis", range, {{0.1 * range.hi, 0}, {0.4 * range.hi, 0.2}, {range.hi, 0.5}});
  FrameOptions options = obliqueView(Projection::kPerspective, {64, 60});
  options.lighting = lookingAround(0.9, 0.6);
  options.step_vox = 0.5;
  options.integrates = true;
  expectRightPicture(*source, transfer, options, options, true);
  options.integrates = false;
  transfer.surfaces = {{0.3 * range.hi, 0.4, {0.2, 0.9, 0.4}}, {0.6 * range.hi, 1, {1, 0.3, 0.1}}};
  expectRightPicture(*source, transfer, options, options, true);
}

TEST_F(LightTest, whatIsCroppedOrClippedAwayCastsNoShadow) {
  // A plate above a ball.
  const auto of = [](bool with_plate) {
    return makeMemorySource<uint8_t>(Vec3i{40, 40, 40}, [=](int64_t x, int64_t y, int64_t z) {
      const int64_t from = (x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 12) * (z - 12);
      return from < 81 || (with_plate && z >= 32) ? 200 : 0;
    });
  };
  const auto both = of(true), ball = of(false);
  const TransferFunction transfer = pointsTransfer("grey", {0, 255}, {{50, 0}, {150, 0.9}});
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.camera.framing = Framing{{19.5, 19.5, 19.5}, 30};
  options.lighting = lookingAround(1, 1);
  options.lighting.lights[0].toward = {0, 0, 1};  // from the viewer
  options.camera.azimuth_deg = 0;
  options.camera.elevation_deg = 0;  // down the z axis, through the plate
  RenderScene with(device(), *both, transfer, {.block_vox = 8, .lit = true});
  RenderScene without(device(), *ball, transfer, {.block_vox = 8, .lit = true});
  const FloatPicture alone = without.draw(options);
  const FloatPicture behind = with.draw(options);
  FrameOptions cropped = options;
  cropped.crop = Box3{{0, 0, 0}, {40, 40, 29}};
  EXPECT_TRUE(within(1, with.draw(cropped), without.draw(cropped)));
  EXPECT_TRUE(within(kOfLitReference, with.draw(cropped), with.reference(cropped)));
  FrameOptions clipped = options;
  clipped.clip_planes = {{{0.1, 0, 1}, 28}};
  EXPECT_TRUE(within(1, with.draw(clipped), without.draw(clipped)));
  EXPECT_TRUE(within(kOfLitReference, with.draw(clipped), with.reference(clipped)));
  EXPECT_FALSE(within(20, behind, alone));
}

TEST_F(LightTest, blocksOfAnySizeAndLittleMemoryMakeNoDifference) {
  // Texels of two voxels, the last of which are cut.
  const auto source = makeSparseBlobs({.dims = {150, 61, 47}, .blobs = 9, .radius_vox = 22});
  const ValueRange range = valueRangeOf(*source);
  const TransferFunction transfer = pointsTransfer("viridis", range, {{20, 0}, {60, 0.5}});
  FrameOptions options = obliqueView(Projection::kPerspective);
  options.lighting = lookingAround(1, 1);
  RenderScene whole(device(), *source, transfer, {.block_vox = 256, .lit = true});
  const FloatPicture picture = whole.draw(options);
  EXPECT_TRUE(within(kOfLitReference, picture, whole.reference(options)));
  FrameOptions plain = options;
  plain.lighting = {};
  EXPECT_FALSE(within(20, picture, whole.draw(plain)));
  for (const int64_t block : {8, 16, 64}) {
    RenderScene scene(device(), *source, transfer,
                      {.block_vox = block, .pages = 4096, .threads = 1, .lit = true});
    EXPECT_TRUE(within(1, scene.draw(options), picture)) << block;
  }
}

TEST_F(LightTest, aTexelIsAsOpaqueAsItsVoxels) {
  const auto source = makeSparseBlobs({.dims = {64, 60, 56}, .blobs = 6, .radius_vox = 12});
  RenderScene scene(device(), *source, pointsTransfer("grey", {0, 255}, {{20, 0}, {60, 0.3}}),
                    {.block_vox = 16, .lit = true});
  const Look look = makeLook(scene.step(), pointsTransfer("grey", {0, 255}, {{20, 0}, {60, 0.3}}),
                             Mode::kComposite);
  WorkerPool pool(2);
  const CoarseExtinction matter =
      coarseExtinction(scene.step(), look, MatterFrom::kFinest, pool, {});
  double sum = 0, by_hand = 0;
  for (const float extinction : matter.per_length) sum += extinction;
  for (const std::byte voxel : source->bytes())
    by_hand -= std::log(1 - opacityAt(look.transfer, std::to_integer<int>(voxel)));
  EXPECT_NEAR(sum, by_hand, 1e-4 * by_hand);
}

// Matter of a surface alone, of opacity 0.3.
CoarseExtinction matterOfSurface(RenderScene& scene, TransferFunction transfer, double value) {
  transfer.surfaces = {{value, 0.3, {1, 1, 1}}};
  WorkerPool pool(2);
  return coarseExtinction(scene.step(), makeLook(scene.step(), transfer, Mode::kComposite),
                          MatterFrom::kFinest, pool, {});
}

TEST_F(LightTest, aSurfaceIsAsOpaqueAsItsArea) {
  const TransferFunction transfer = pointsTransfer("grey", {0, 100}, {{0, 0}});
  for (const Vec3d spacing : {Vec3d{1, 1, 1}, Vec3d{1, 1.5, 2}}) {
    VolumeLayout layout;
    layout.dims = {48, 48, 48};
    layout.type = VoxelType::kF32;
    layout.spacing = spacing;
    std::vector<float> voxels;
    const Vec3d center = toDouble(layout.dims - Vec3i{1, 1, 1}) * 0.5 * spacing;
    Vec3i at;
    for (at.z = 0; at.z < 48; ++at.z)
      for (at.y = 0; at.y < 48; ++at.y)
        for (at.x = 0; at.x < 48; ++at.x)
          voxels.push_back(static_cast<float>(length(toDouble(at) * spacing - center)));
    const auto bytes = std::as_bytes(std::span(voxels));
    MemorySource source(layout, {bytes.begin(), bytes.end()});
    RenderScene scene(device(), source, transfer, {.block_vox = 16, .lit = true});
    for (const double radius : {9.0, 14.3, 20.7}) {
      const CoarseExtinction matter = matterOfSurface(scene, transfer, radius);
      double sum = 0;
      for (const float extinction : matter.per_length) sum += extinction;
      const double area = 4 * 3.14159265 * radius * radius / (spacing.x * spacing.y * spacing.z);
      EXPECT_NEAR(sum, -std::log(0.7) * area, 0.03 * area) << radius << ", " << spacing.z;
    }
  }
}

TEST_F(LightTest, aTiltedSurfaceCastsAnEvenShadow) {
  for (const Vec3d slope : {Vec3d{0, 0, 1}, Vec3d{0.17, 0.11, 1}, Vec3d{0.5, 0.3, 1}}) {
    const auto source = makeMemorySource<float>(Vec3i{41, 41, 41}, [&](auto x, auto y, auto z) {
      return dot(slope, toDouble(Vec3i{x, y, z}));
    });
    const TransferFunction transfer = pointsTransfer("grey", {0, 100}, {{0, 0}});
    RenderScene scene(device(), *source, transfer, {.block_vox = 16, .lit = true});
    const CoarseExtinction matter = matterOfSurface(scene, transfer, dot(slope, {20, 20, 28}));
    for (const Vec3d toward : {Vec3d{0, 0, 1}, Vec3d{0.3, 0.1, 1}}) {
      WorkerPool pool(1);
      std::vector<float> light(matter.per_length.size(), 0.0F);
      addLight(matter, {toward, length(toward), 0}, 1, pool, light);
      double least = 1, greatest = 0, mean = 0;
      for (int64_t y = 14; y < 28; ++y)
        for (int64_t x = 14; x < 28; ++x) {
          const double here = lightTexel(light, matter.grid.texels, {x, y, 5});
          least = std::min(least, here);
          greatest = std::max(greatest, here);
          mean += here / (14 * 14);
        }
      SCOPED_TRACE(fmt::format("slope {} {}, light {}", slope.x, slope.y, toward.x));
      EXPECT_LT(greatest - least, 0.04) << "it is no staircase";
      // The way through a sheet is longer the flatter the light falls on it.
      const double facing = dot(slope, toward) / (length(slope) * length(toward));
      EXPECT_NEAR(mean, std::pow(0.7, 1 / facing), 0.02);
    }
  }
}

TEST_F(LightTest, opacitiesThatDependOnGradientsAreRefused) {
  const auto source = makeSparseBlobs({.dims = {24, 24, 24}});
  RenderScene scene(device(), *source,
                    modulateByGradient(pointsTransfer("grey", {0, 255}, {{20, 0}, {60, 0.3}}), 20),
                    {.block_vox = 16, .lit = true});
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.lighting = lookingAround(1, 0);
  EXPECT_THROW(scene.draw(options), Error);
}

}  // namespace
}  // namespace sluice
