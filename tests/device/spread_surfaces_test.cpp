// Surfaces in chunks whose texels stand for many values.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/device/spread_chunks.h"
#include "tests/support/plain_device.h"

namespace sluice::spread_chunks {
namespace {

using SpreadSurfaces = SpreadTest;

// A smooth field, so that rounding moves no surface far, with any spread.
Texel wavesAt(int64_t i) {
  const auto x = static_cast<double>(i % kDims.x), y = static_cast<double>(i / kDims.x % kDims.y),
             z = static_cast<double>(i / (kDims.x * kDims.y));
  return {std::floor(128 + 70 * std::sin(x / 4) * std::cos(y / 5) + 50 * std::sin(z / 3 + 0.3)),
          noiseAt(i).spread / 4};
}

FrameSetup withSurfaces(FrameSetup setup, bool is_alone) {
  LookUp look_up = *setup.look_up;
  if (is_alone)
    for (size_t i = 3; i < look_up.rgba.size(); i += 4) look_up.rgba[i] = 0;
  look_up.surfaces = {{90.3, 0.4, {0.2, 0.9, 0.4}}, {150.6, 1, {1, 0.3, 0.1}}};
  look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(look_up, kRange));
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  setup.has_surfaces = true;
  return setup;
}

int64_t pixelsApart(const Picture& a, const Picture& b, double tolerance_255) {
  int64_t apart = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    double worst = 0;
    for (size_t c = i; c < i + 4; ++c)
      worst = std::max(worst, std::abs(255.0 * a.rgba[c] - 255.0 * b.rgba[c]));
    apart += worst > tolerance_255 ? 1 : 0;
  }
  return apart;
}

// Rays that touch a surface may meet it or not by rounding.
constexpr int64_t kMostTouching = 2;

TEST_F(SpreadSurfaces, surfacesLieWhereTheMeansPassTheirValues) {
  PlainDevice plain;
  for (const DeviceType type : kTypes)
    for (const Seen& seen : composites()) {
      // Factors of gradients do not depend on the type, nor do surfaces on the opacities.
      if (seen.is_opaque || (seen.with_gradients && type != DeviceType::kU8)) continue;
      for (const bool is_alone : {false, true})
        for (const Vec3d scale : {Vec3d{1, 1, 1}, {0.5, 0.25, 0.5}}) {
          SCOPED_TRACE(
              fmt::format("{} {} alone {} scale {}", name(type), seen.words(), is_alone, scale.x));
          const FrameSetup setup = withSurfaces(setupOf(seen, type), is_alone);
          const ChunkTexelsPtr chunk = chunkOf(wavesAt, type, true);
          const Picture drawn = drawOn(*device_, setup, chunk, scale);
          EXPECT_GT(mostOpacity(drawn), 0.99);
          EXPECT_LE(pixelsApart(drawn, drawOn(plain, setup, chunk, scale), 2), kMostTouching);
          if (!is_alone) continue;
          // Without opacities the spreads make no difference.
          const ChunkTexelsPtr means = chunkOf(wavesAt, type, false);
          EXPECT_LE(pixelsApart(drawn, drawOn(*device_, setup, means, scale), 1), kMostTouching);
        }
    }
}

TEST_F(SpreadSurfaces, besideABoxOpaqueSurfacesAloneShow) {
  PlainDevice plain;
  for (const bool has_spread : {false, true}) {
    const FrameSetup setup = withSurfaces(setupOf({}, DeviceType::kU8), false);
    const ChunkTexelsPtr chunk = chunkOf(wavesAt, DeviceType::kU8, has_spread);
    const auto drawBeside = [&](Device& device) {
      BoxDraw box;
      box.chunk = 1;
      box.cells = {{3, 2, 1}, {kDims.x - 1, kDims.y - 1, kDims.z - 1}};
      box.beside = Box3{{0, 0, 0}, {3, 2, 1}};
      return drawOneBox(device, setup, chunk, box);
    };
    const Picture drawn = drawBeside(*device_);
    EXPECT_GT(mostOpacity(drawn), 0.99);
    EXPECT_LE(pixelsApart(drawn, drawBeside(plain), 2), kMostTouching);
    for (size_t i = 3; i < drawn.rgba.size(); i += 4)
      EXPECT_TRUE(drawn.rgba[i] == 0 || drawn.rgba[i] > 0.99F);
  }
}

// Shares that rise along one axis and fall along another. Opaque surfaces are drawn in full.
TEST_F(SpreadSurfaces, surfacesThatLetLightThroughHaveTheirShareOfAFade) {
  PlainDevice plain;
  LevelFade fade;
  fade.slope[0] = 0.08;
  fade.start[0] = -0.2;
  fade.slope[5] = -0.1;
  fade.start[5] = 1.3;
  for (const bool has_spread : {false, true})
    for (const bool lit : {false, true})
      for (const int trimming_axis : {0, 2})
        for (const std::optional<Box3>& beside :
             {std::optional<Box3>(), std::optional(Box3{{0, 0, 0}, {3, 2, 1}})}) {
          SCOPED_TRACE(fmt::format("spread {}, lit {}, axis {}, beside {}", has_spread, lit,
                                   trimming_axis, beside.has_value()));
          const FrameSetup setup = withSurfaces(setupOf({.lit = lit}, DeviceType::kU8), true);
          const ChunkTexelsPtr chunk = chunkOf(wavesAt, DeviceType::kU8, has_spread);
          const auto drawWith = [&](Device& device, const std::optional<LevelFade>& with) {
            BoxDraw box;
            box.chunk = 1;
            box.cells = {{3, 2, 1}, {14, 15, 13}};
            if (trimming_axis == 0) box.texels.axes = {1, 2, 0};
            box.texels.scale = {0.5, 0.8, 0.5};
            box.texels.offset = {1, 1.5, 2};
            box.beside = beside;
            box.fade = with;
            return drawOneBox(device, setup, chunk, box);
          };
          const Picture drawn = drawWith(*device_, fade);
          EXPECT_LE(pixelsApart(drawn, drawWith(plain, fade), 2), kMostTouching);
          const Picture whole = drawWith(*device_, LevelFade());
          EXPECT_GT(pixelsApart(drawn, whole, 10), 30);
          EXPECT_GT(mostOpacity(drawn), 0.99);
          if (!beside) {
            EXPECT_EQ(pixelsApart(whole, drawWith(*device_, std::nullopt), 0.01), 0);
          }
        }
}

// Boxes of two other chunks join one: all lie in one medium, in which each slice has its place.
TEST_F(SpreadSurfaces, ofBoxesThatJoinOneLieAtTheirPlacesInIt) {
  const auto movedAt = [](int64_t i) { return wavesAt((i + 3) % (kDims.x * kDims.y * kDims.z)); };
  for (const bool has_spread : {false, true})
    for (const bool lit : {false, true})
      for (const DeviceType type : {DeviceType::kU8, DeviceType::kF32}) {
        SCOPED_TRACE(fmt::format("spread {}, lit {}, {}", has_spread, lit, name(type)));
        const FrameSetup setup = withSurfaces(setupOf({.lit = lit}, type), false);
        const ChunkTexelsPtr fine = chunkOf(wavesAt, type, false);
        const ChunkTexelsPtr coarse = chunkOf(movedAt, type, has_spread);
        const auto drawWith = [&](Device& device, bool joins) {
          BoxDraw box;
          box.chunk = 1;
          box.cells = {{3, 2, 1}, {14, 15, 13}};
          std::vector<BoxDraw> boxes(3, box);
          for (size_t i = 1; i < boxes.size(); ++i) {
            boxes[i].chunk = 1 + i;
            boxes[i].texels.scale = {0.5, 0.8, 0.5};
            boxes[i].texels.offset = {1, 1.5, 2};
            boxes[i].beside = box.cells;
            boxes[i].joins = joins;
            boxes[i].fade.emplace();
          }
          boxes[1].cells.lo.x = 8;
          boxes[2].cells.hi.y = 9;
          boxes[2].texels.axes = {1, 2, 0};
          boxes[2].fade->slope[0] = 0.08;
          boxes[2].fade->start[0] = -0.2;
          device.makeResident(1, fine);
          device.makeResident(2, coarse);
          device.makeResident(3, coarse);
          device.beginFrame(setup);
          device.draw(boxes);
          Picture picture = device.endFrame();
          for (const uint64_t id : {1, 2, 3}) device.evict(id);
          return picture;
        };
        PlainDevice plain;
        const Picture drawn = drawWith(*device_, true);
        EXPECT_LE(pixelsApart(drawn, drawWith(plain, true), 2), kMostTouching);
        EXPECT_GT(pixelsApart(drawn, drawWith(*device_, false), 4), 20);
      }
}

}  // namespace
}  // namespace sluice::spread_chunks
