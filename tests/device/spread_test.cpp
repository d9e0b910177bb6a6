// Chunks whose texels stand for many values, against answers on paper and the plain device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/device/spread_chunks.h"
#include "tests/support/plain_device.h"

namespace sluice::spread_chunks {
namespace {

TEST_F(SpreadTest, noSpreadIsThePictureOfTheMeans) {
  const auto means = [](int64_t i) { return Texel{noiseAt(i).mean, 0}; };
  for (const DeviceType type : kTypes)
    for (const Seen& seen : composites()) {
      // Gradients are taken from more texels where these stand for many values.
      if (seen.lit || seen.with_gradients) continue;
      const FrameSetup setup = setupOf(seen, type);
      const Picture one = drawOn(*device_, setup, chunkOf(means, type, false));
      EXPECT_GT(mostOpacity(one), 0.1);
      EXPECT_LT(worstOf(drawOn(*device_, setup, chunkOf(means, type, true)), one), 0.5)
          << name(type) << ' ' << seen.words();
    }
}

TEST_F(SpreadTest, modesOtherThanCompositeLookAtMeansAlone) {
  for (const DeviceType type : kTypes)
    for (const Mode mode :
         {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip, Mode::kDepthMip}) {
      const FrameSetup setup = setupOf({Projection::kPerspective, mode}, type);
      const Picture one = drawOn(*device_, setup, chunkOf(noiseAt, type, false));
      EXPECT_GT(mostOpacity(one), 0.1);
      EXPECT_LT(worstOf(drawOn(*device_, setup, chunkOf(noiseAt, type, true)), one), 0.1);
    }
}

TEST_F(SpreadTest, spreadsGiveThePictureOfPlainLoops) {
  PlainDevice plain;
  for (const DeviceType type : kTypes)
    for (const Seen& seen : composites())
      for (const Vec3d scale : {Vec3d{1, 1, 1}, {0.5, 0.25, 0.5}}) {
        SCOPED_TRACE(fmt::format("{} {} scale {}", name(type), seen.words(), scale.x));
        const FrameSetup setup = setupOf(seen, type);
        const ChunkTexelsPtr chunk = chunkOf(noiseAt, type, true);
        EXPECT_LT(
            worstOf(drawOn(*device_, setup, chunk, scale), drawOn(plain, setup, chunk, scale)), 2);
      }
}

// The nearest mean shows something: a sample with any part of a NaN takes neither that look nor the
// look of its neighbours.
TEST_F(SpreadTest, samplesThatMeetATexelThatIsNoNumberShowNothing) {
  PlainDevice plain;
  const auto texelAt = [](int64_t i) {
    const int64_t x = i % kDims.x, z = i / (kDims.x * kDims.y);
    if (x < 7) return Texel{kNotANumber, z < 8 ? kNotANumber : 0};
    if (i % 97 == 0) return Texel{kNotANumber, 60};
    return noiseAt(i);
  };
  for (const Seen& seen : composites()) {
    SCOPED_TRACE(seen.words());
    FrameSetup setup = setupOf(seen, DeviceType::kF32);
    // Low values are opaque, too.
    LookUp look_up = *setup.look_up;
    for (size_t i = 3; i < look_up.rgba.size(); i += 4)
      look_up.rgba[i] = std::max(look_up.rgba[i], 0.1F);
    look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(look_up, kRange));
    setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
    const ChunkTexelsPtr chunk = chunkOf(texelAt, DeviceType::kF32, true);
    const Picture drawn = drawOn(*device_, setup, chunk);
    EXPECT_GT(mostOpacity(drawn), 0.1);
    EXPECT_LT(worstOf(drawn, drawOn(plain, setup, chunk)), 2);
  }
}

// n unit lengths of values, a share of which is opaque, let (1 - share)^n through.
TEST_F(SpreadTest, theOpacityIsThatOfTheShareThatIsOpaque) {
  PlainDevice plain;
  for (Device* device : {device_.get(), static_cast<Device*>(&plain)})
    for (const double spread : {20.0, 50.0, 125.0}) {
      Seen seen;
      FrameSetup setup = setupOf(seen, DeviceType::kF32);
      LookUp step = *setup.look_up;
      const auto entries = static_cast<double>(step.rgba.size() / 4);
      const ValueRange range = step.device_range;
      for (size_t i = 0; i < step.rgba.size(); i += 4) {
        const double value =
            range.lo + (range.hi - range.lo) * static_cast<double>(i / 4) / (entries - 1);
        step.rgba[i] = step.rgba[i + 1] = step.rgba[i + 2] = 1;
        step.rgba[i + 3] = value < 120 ? 0 : 0.3F;
      }
      step.interpolates = false;
      step.expected = std::make_shared<const ExpectedLook>(expectedLook(step, kRange));
      setup.look_up = std::make_shared<const LookUp>(step);
      const double mean = 115;
      // Uniform over sqrt(3) standard deviations to either side.
      const double reach = std::sqrt(3.0) * spread / 2;
      const double share = (mean + reach - 120) / (2 * reach);
      const Picture spreads = drawOn(*device, setup,
                                     chunkOf(
                                         [&](auto) {
                                           return Texel{mean, spread};
                                         },
                                         DeviceType::kF32, true));
      // The same way through values of that opacity.
      LookUp same = step;
      for (size_t i = 3; i < same.rgba.size(); i += 4)
        same.rgba[i] = static_cast<float>(0.3 * share);
      setup.look_up = std::make_shared<const LookUp>(same);
      const Picture expected = drawOn(*device, setup,
                                      chunkOf(
                                          [&](auto) {
                                            return Texel{mean, 0};
                                          },
                                          DeviceType::kF32, false));
      EXPECT_GT(mostOpacity(expected), 0.3);
      EXPECT_LT(worstOf(spreads, expected), 2) << device->backend() << ' ' << spread;
    }
}

// All values look the same, so that spreads change the light alone.
constexpr Vec3d kOneColor{0.6, 0.5, 0.4};
FrameSetup setupOfOneColor(DeviceType type) {
  FrameSetup setup = setupOf({Projection::kPerspective, Mode::kComposite, true}, type);
  LookUp look_up = *setup.look_up;
  for (size_t i = 0; i < look_up.rgba.size(); ++i)
    look_up.rgba[i] = i % 4 == 3 ? 0.2F : static_cast<float>(kOneColor[static_cast<int>(i % 4)]);
  look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(look_up, kRange));
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  return setup;
}

// The sum over the axes of the square of the slope in the world that one value a texel is.
double slopeSquares(const FrameSetup& setup, Vec3d scale) {
  double sum = 0;
  for (size_t a = 0; a < 3; ++a) {
    const Vec3d slope = setup.camera_gradient[a] * scale[static_cast<int>(a)];
    sum += dot(slope, slope);
  }
  return sum;
}

TEST_F(SpreadTest, aTextureIsLitAlikeFromAllSides) {
  PlainDevice plain;
  for (Device* device : {device_.get(), static_cast<Device*>(&plain)})
    for (const DeviceType type : kTypes)
      for (const Vec3d scale : {Vec3d{1, 1, 1}, {0.5, 0.25, 0.5}})
        for (const double spread : {0.0, 6.0, 50.0}) {
          SCOPED_TRACE(fmt::format("{} {} scale {} spread {}", device->backend(), name(type),
                                   scale.x, spread));
          const FrameSetup setup = setupOfOneColor(type);
          const Picture drawn = drawOn(*device, setup,
                                       chunkOf(
                                           [&](auto) {
                                             return Texel{128, spread};
                                           },
                                           type, true),
                                       scale);
          // No slope from texel to texel: all of the variance lies in slopes of all directions.
          // All texels have it, so that it is noise, too, whose slopes are those of voxels.
          const double texel_voxels = std::pow(scale.x * scale.y * scale.z, -1.0 / 3);
          const double squared = spread * spread * (0.25 / 5 + 0.08 * texel_voxels * texel_voxels) *
                                 slopeSquares(setup, scale);
          const double part = squared / (squared + setup.flat * setup.flat);
          const Lighting& light = setup.lighting;
          const double strengths = light.lights[0].strength + light.lights[1].strength;
          const double bright = 1 - part + part * (light.ambient + 0.5 * light.diffuse * strengths);
          const double gleam = part * light.specular * strengths / (light.shininess + 1);
          double worst = 0;
          for (size_t i = 0; i < drawn.rgba.size(); i += 4)
            for (int c = 0; c < 3; ++c) {
              const double found{drawn.rgba[i + static_cast<size_t>(c)]};
              const double expected = double{drawn.rgba[i + 3]} * (kOneColor[c] * bright + gleam);
              worst = std::max(worst, std::abs(255 * (found - expected)));
            }
          EXPECT_GT(mostOpacity(drawn), 0.9);
          EXPECT_LT(worst, 1);
        }
}

TEST_F(SpreadTest, anEvenSlopeIsLitAsWithoutItsSpread) {
  // From texel to texel; the spread is that of the values on the way through a texel.
  constexpr Vec3d kSlope{6, 3, 2};
  const double spread = length(kSlope) / std::sqrt(3.0);
  PlainDevice plain;
  const auto rampAt = [&](bool has_spread) {
    return [&kSlope, has_spread, spread](int64_t i) {
      const Vec3i at{i % kDims.x, i / kDims.x % kDims.y, i / (kDims.x * kDims.y)};
      // Beside the border differences are smaller.
      bool is_inside = true;
      for (int a = 0; a < 3; ++a) is_inside = is_inside && at[a] > 1 && at[a] < kDims[a] - 2;
      return Texel{20 + dot(kSlope, toDouble(at)), has_spread && is_inside ? spread : 0};
    };
  };
  for (Device* device : {device_.get(), static_cast<Device*>(&plain)}) {
    const FrameSetup setup = setupOfOneColor(DeviceType::kF32);
    const Picture one = drawOn(*device, setup, chunkOf(rampAt(false), DeviceType::kF32, true));
    EXPECT_LT(worstOf(drawOn(*device, setup, chunkOf(rampAt(true), DeviceType::kF32, true)), one),
              0.5)
        << device->backend();
    // Four times the spread is more than the slope explains.
    const auto rough = [&](int64_t i) {
      const Texel texel = rampAt(true)(i);
      return Texel{texel.mean, 4 * texel.spread};
    };
    EXPECT_GT(worstOf(drawOn(*device, setup, chunkOf(rough, DeviceType::kF32, true)), one), 5);
  }
}

TEST_F(SpreadTest, leapingLeavesOutNothingThatShows) {
  for (const Seen& seen : composites()) {
    FrameSetup setup = setupOf(seen, DeviceType::kU8);
    // Mostly nothing, whose spread alone shows something.
    const ChunkTexelsPtr chunk = chunkOf(
        [](int64_t i) {
          const int64_t x = i % kDims.x, z = i / (kDims.x * kDims.y);
          return x > 14 && z < 9 ? Texel{60, 70} : x < 5 && z > 11 ? noiseAt(i) : Texel{20, 6};
        },
        DeviceType::kU8, true);
    setup.skips = false;
    const Picture whole = drawOn(*device_, setup, chunk);
    setup.skips = true;
    EXPECT_GT(mostOpacity(whole), 0.1);
    EXPECT_LT(worstOf(drawOn(*device_, setup, chunk), whole), 0.5) << seen.words();
  }
}

}  // namespace
}  // namespace sluice::spread_chunks
