// Chunks whose texels stand for many values, against answers on paper and the plain device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/draw_one_box.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{23, 19, 17};
constexpr ValueRange kRange{0, 255};

struct Texel {
  double mean = 0, spread = 0;
};
using TexelAt = std::function<Texel(int64_t)>;  // by its number

// Two numbers a texel, or the means alone.
ChunkTexelsPtr chunkOf(const TexelAt& texel_at, DeviceType type, bool has_spread) {
  std::vector<std::byte> bytes;
  for (int64_t i = 0; i < volume(kDims); ++i) {
    const Texel texel = texel_at(i);
    const auto add = [&](double number) {
      visitDeviceType(type, [&](auto tag) {
        const auto value = static_cast<decltype(tag)>(number);
        const auto* from = reinterpret_cast<const std::byte*>(&value);
        bytes.insert(bytes.end(), from, from + sizeof value);
      });
    };
    add(texel.mean);
    if (has_spread) add(texel.spread);
  }
  auto chunk = std::make_shared<ChunkTexels>(*chunkTexels(kDims, type, bytes));
  chunk->has_spread = has_spread;
  return chunk;
}

Texel noiseAt(int64_t i) {
  uint32_t state = static_cast<uint32_t>(i) * 2654435761U + 12345U;
  state ^= state >> 15;
  state *= 2246822519U;
  state ^= state >> 13;
  const double mean = state >> 24;
  // From none to the greatest that the mean allows.
  const double most = 2 * std::sqrt(mean * (255 - mean)), share = (state >> 8 & 255) / 255.0;
  return {mean, i % 5 == 0 ? 0 : std::floor(most * share * share)};
}

struct Seen {
  Projection projection = Projection::kOrtho;
  Mode mode = Mode::kComposite;
  bool lit = false, with_gradients = false, is_opaque = false;

  std::string words() const {
    return fmt::format("projection {} mode {} lit {} gradients {} opaque {}",
                       static_cast<int>(projection), static_cast<int>(mode), lit, with_gradients,
                       is_opaque);
  }
};

FrameSetup setupOf(const Seen& seen, DeviceType type) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = {1, 1.2, 0.9};
  FrameOptions options;
  options.camera.projection = seen.projection;
  options.camera.azimuth_deg = 36;
  options.camera.elevation_deg = 27;
  options.size = {45, 39};
  options.step_vox = 0.7;
  options.mode = seen.mode;
  TransferFunction transfer{{{0, {0.1, 0.3, 0.9}}, {140, {0.9, 0.9, 0.2}}, {255, {1, 0.6, 0.1}}},
                            {{100, 0}, {180, seen.is_opaque ? 1 : 0.15}, {220, 0}},
                            "t"};
  if (seen.with_gradients) transfer.gradients = {{5, {{0, 0.2}}}, {60, {{0, 1}}}};
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, kRange), map, options);
  setup.type = type;
  setup.lit = seen.lit;
  setup.window = {0, 255};
  setup.depth_colors = {{1, 0.6, 0.1}, {0.1, 0.3, 0.9}};
  LookUp look_up = *setup.look_up;
  look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(look_up, kRange));
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  return setup;
}

Picture drawOn(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& chunk,
               Vec3d scale = {1, 1, 1}) {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kDims - Vec3i{1, 1, 1});
  box.texels.scale = scale;
  box.texels.offset = (Vec3d{1, 1, 1} - scale) * 3.0;
  return drawOneBox(device, setup, chunk, box);
}

double worstOf(const Picture& a, const Picture& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i)
    worst = std::max(worst, std::abs(255.0 * a.rgba[i] - 255.0 * b.rgba[i]));
  return worst;
}
double mostOpacity(const Picture& picture) {
  float most = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) most = std::max(most, picture.rgba[i]);
  return most;
}

std::vector<Seen> composites() {
  std::vector<Seen> result;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const bool is_opaque : {false, true})
      for (const auto& [lit, with_gradients] :
           {std::pair{false, false}, {true, false}, {false, true}, {true, true}})
        result.push_back({projection, Mode::kComposite, lit, with_gradients, is_opaque});
  return result;
}

constexpr DeviceType kTypes[] = {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32};

class SpreadTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static inline std::unique_ptr<Device> device_;
};

TEST_F(SpreadTest, noSpreadIsThePictureOfTheMeans) {
  const auto means = [](int64_t i) { return Texel{noiseAt(i).mean, 0}; };
  for (const DeviceType type : kTypes)
    for (const Seen& seen : composites()) {
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

TEST_F(SpreadTest, surfacesLieWhereTheMeansPassTheirValues) {
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

TEST_F(SpreadTest, besideABoxOpaqueSurfacesAloneShow) {
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

// Shares that rise along one axis and fall along another.
TEST_F(SpreadTest, surfacesThatLetLightThroughHaveTheirShareOfAFade) {
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
          if (beside) {
            EXPECT_LT(mostOpacity(whole), 0.99) << "no opaque surface";
          } else {
            EXPECT_GT(mostOpacity(drawn), 0.99);
            EXPECT_EQ(pixelsApart(whole, drawWith(*device_, std::nullopt), 0.01), 0);
          }
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
          const double squared = spread * spread / 4 / 5 * slopeSquares(setup, scale);
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
}  // namespace sluice
