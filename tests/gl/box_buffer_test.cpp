// Checks the vertex shader's input in numbers: neighbours share their faces to the last bit, texel
// rays follow the double-precision formula, and the drawn cube covers its box.
#include "src/gl/box_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

struct Scene {
  VolumeLayout layout;
  View view;
  FrameSetup setup;
};

Scene sceneOf(const VolumeLayout& layout, Projection projection,
              std::optional<Camera::LookAt> look_at = std::nullopt) {
  FrameOptions options;
  options.camera.projection = projection;
  options.camera.azimuth_deg = 33;
  options.camera.elevation_deg = 21;
  options.camera.look_at = look_at;
  options.size = {200, 150};
  const View view = resolve(options.camera, layout, options.size, 0.7);
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{0, 0.5}}, "test"};
  return {layout, view,
          frameSetup(view, layout, OpacityTable(transfer, map, {0, 255}), map, options)};
}

VolumeLayout skewed() {
  VolumeLayout layout;
  layout.dims = {300, 200, 100};
  layout.spacing = {1, 1.5, 0.4};
  layout.axes = {{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}};
  layout.origin = {-20, 5, 1000};
  return layout;
}

// The four floats of texel `texel` of box `box`.
std::array<float, 4> texelOf(const std::vector<float>& texels, size_t box, size_t texel) {
  const float* at = texels.data() + (box * kTexelsPerBox + texel) * 4;
  return {at[0], at[1], at[2], at[3]};
}

constexpr Projection kProjections[] = {Projection::kOrtho, Projection::kPerspective};

TEST(BoxBuffer, neighboursShareTheirFaceToTheLastBit) {
  for (const Projection projection : kProjections) {
    const Scene scene = sceneOf(skewed(), projection);
    BoxDraw left, right;
    left.cells = {{3, 5, 7}, {131, 60, 40}};
    right.cells = {{131, 5, 7}, {260, 60, 40}};
    right.texels = {{1, 2, 0}, {1, 1, 1}, {-130, -4, -6}};
    const BoxDraw both[] = {left, right};
    const std::vector<float> texels = boxTexels(scene.setup, both);
    ASSERT_EQ(texels.size(), size_t{2} * kTexelsPerBox * 4);
    EXPECT_EQ(texelOf(texels, 0, 9)[0], texelOf(texels, 1, 8)[0]) << "hi.x of left, lo.x of right";
    for (const size_t a : {size_t{1}, size_t{2}}) {
      EXPECT_EQ(texelOf(texels, 0, 8)[a], texelOf(texels, 1, 8)[a]);
      EXPECT_EQ(texelOf(texels, 0, 9)[a], texelOf(texels, 1, 9)[a]);
    }
    EXPECT_EQ(texelOf(texels, 0, 9)[3], 2) << "the axis that became texture z";
    EXPECT_EQ(texelOf(texels, 1, 9)[3], 0);
  }
}

TEST(BoxBuffer, texelRaysAreThoseOfTheView) {
  for (const Projection projection : kProjections) {
    const Scene scene = sceneOf(skewed(), projection);
    for (const std::array<int, 3>& axes : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
      BoxDraw box;
      box.cells = {{130, 60, 40}, {160, 90, 70}};
      box.texels = {axes, {0.5, 1, 3}, {-49.75, -50, -90}};
      const std::vector<float> texels = boxTexels(scene.setup, {&box, 1});
      const double first_k = texelOf(texels, 0, 8)[3];
      for (const auto& [x, y] : {std::pair(0.5, 0.5), {100.5, 75.5}, {199.5, 3.5}}) {
        // By the definition in camera.h; y is upwards here.
        const double u = 2 * x / 200 - 1, v = 2 * y / 150 - 1, aspect = 200.0 / 150;
        const double depth = scene.view.first_depth + (first_k + 0.5) * scene.view.step;
        const Vec3d aside = scene.view.right * (u * aspect * scene.view.half_height) +
                            scene.view.up * (v * scene.view.half_height);
        const Vec3d world = projection == Projection::kOrtho
                                ? scene.view.eye + aside + scene.view.forward * depth
                                : scene.view.eye + (scene.view.forward + aside) * depth;
        const Vec3d index = indexFromWorld(scene.layout, world);
        for (size_t a = 0; a < 3; ++a) {
          const double texel = index[axes[a]] * std::array{0.5, 1.0, 3.0}[a] -
                               std::array{49.75, 50.0, 90.0}[a] + 0.5;
          const double found = texelOf(texels, 0, 10)[a] + x * texelOf(texels, 0, 11)[a] +
                               y * texelOf(texels, 0, 12)[a];
          EXPECT_NEAR(found, texel, 1e-3) << "axis " << a << " at " << x << ", " << y;
        }
      }
    }
  }
}

// Everything is relative to the box, so that single precision lasts far from the origin.
TEST(BoxBuffer, texelRaysStayExactInEnormousVolumes) {
  VolumeLayout layout;
  layout.dims = {int64_t{1} << 22, int64_t{1} << 22, int64_t{1} << 22};
  const Vec3d target{4e6, 4e6, 4e6};
  const Scene scene =
      sceneOf(layout, Projection::kPerspective, Camera::LookAt{target + Vec3d{3, 50, 20}, target});
  BoxDraw box;
  box.cells = {{3999990, 3999990, 3999990}, {4000020, 4000020, 4000020}};
  box.texels.offset = {-3999990, -3999990, -3999990};
  const std::vector<float> texels = boxTexels(scene.setup, {&box, 1});
  // The picture's centre at the box's first slice.
  const double depth = scene.view.first_depth + (texelOf(texels, 0, 8)[3] + 0.5) * scene.view.step;
  EXPECT_GT(depth, -1) << "the slices before the eye are left out";
  const Vec3d expected = scene.view.eye + scene.view.forward * depth;
  for (size_t a = 0; a < 3; ++a) {
    const double found = texelOf(texels, 0, 10)[a] + 100.0 * texelOf(texels, 0, 11)[a] +
                         75.0 * texelOf(texels, 0, 12)[a];
    EXPECT_NEAR(found, expected[static_cast<int>(a)] - 3999990 + 0.5, 0.01) << a;
  }
}

TEST(BoxBuffer, drawnCubeCoversItsBox) {
  for (const Projection projection : kProjections) {
    const Scene scene = sceneOf(skewed(), projection);
    BoxDraw box;
    box.cells = {{30, 60, 40}, {160, 90, 70}};
    const std::vector<float> texels = boxTexels(scene.setup, {&box, 1});
    // In pixels: the extent of the drawn corners exceeds the box's by less than two.
    std::array<double, 4> drawn{1e9, -1e9, 1e9, -1e9}, own = drawn;
    const auto take = [](std::array<double, 4>& extent, double x, double y) {
      extent = {std::min(extent[0], x), std::max(extent[1], x), std::min(extent[2], y),
                std::max(extent[3], y)};
    };
    for (size_t corner = 0; corner < 8; ++corner) {
      const auto clip = texelOf(texels, 0, corner);
      take(drawn, clip[0] / clip[2] * 100, clip[1] / clip[2] * 75);
      Vec3d index;
      for (int a = 0; a < 3; ++a)
        index[a] = static_cast<double>((corner >> a & 1) != 0 ? box.cells.hi[a] : box.cells.lo[a]);
      const Vec3d from_eye = worldFromIndex(scene.layout, index) - scene.view.eye;
      const double depth = dot(from_eye, scene.view.forward);
      const double scale = scene.view.half_height * (projection == Projection::kOrtho ? 1 : depth);
      take(own, dot(from_eye, scene.view.right) / (scale * 200 / 150) * 100,
           dot(from_eye, scene.view.up) / scale * 75);
    }
    for (size_t side = 0; side < 4; ++side) {
      const double out = side % 2 == 0 ? own[side] - drawn[side] : drawn[side] - own[side];
      EXPECT_GT(out, 0) << side;
      EXPECT_LT(out, 2) << side;
    }
  }
}

TEST(BoxBuffer, slicesBeforeAPerspectiveEyeAreLeftOut) {
  const VolumeLayout layout = skewed();
  const Vec3d inside = worldFromIndex(layout, {150, 100, 50});
  const Scene scene =
      sceneOf(layout, Projection::kPerspective, Camera::LookAt{inside, inside + Vec3d{1, 2, 3}});
  BoxDraw box;
  box.cells = boxOf(layout.dims - Vec3i{1, 1, 1});
  const double first_k = texelOf(boxTexels(scene.setup, {&box, 1}), 0, 8)[3];
  const double depth = scene.view.first_depth + (first_k + 0.5) * scene.view.step;
  EXPECT_GT(depth, 0);
  EXPECT_LE(depth, scene.view.step);
}

TEST(BoxBuffer, mirroredSpacesAreFound) {
  for (const Projection projection : kProjections) {
    VolumeLayout layout = skewed();
    EXPECT_FALSE(isMirrored(sceneOf(layout, projection).setup));
    layout.axes[1] = -layout.axes[1];
    EXPECT_TRUE(isMirrored(sceneOf(layout, projection).setup));
    std::swap(layout.axes[0], layout.axes[2]);
    EXPECT_FALSE(isMirrored(sceneOf(layout, projection).setup));
  }
}

TEST(BoxBuffer, cubeTrianglesFaceOutwardsAndCoverEachFace) {
  const auto corner = [](uint8_t i) {
    return Vec3d{double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)} - Vec3d{0.5, 0.5, 0.5};
  };
  std::array<double, 6> area{};  // area of the faces -x, +x, -y, ...
  for (size_t i = 0; i < kCubeTriangles.size(); i += 3) {
    const Vec3d a = corner(kCubeTriangles[i]), b = corner(kCubeTriangles[i + 1]),
                c = corner(kCubeTriangles[i + 2]);
    const Vec3d normal = cross(b - a, c - a);
    EXPECT_GT(dot(normal, a + b + c), 0) << "triangle " << i / 3;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(normal[axis]) > 0.5)
        area[static_cast<size_t>(2 * axis + (normal[axis] > 0 ? 1 : 0))] += 0.5 * length(normal);
  }
  for (const double face : area) EXPECT_EQ(face, 1);
}

}  // namespace
}  // namespace sluice
