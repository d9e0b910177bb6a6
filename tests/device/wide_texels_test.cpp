// Light on texels that stand for many values each, see rough_light.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/draw_one_box.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr Vec3i kStepDims{24, 24, 24};
constexpr ValueRange kStepRange{0, 255};
constexpr double kBelow = 20, kAbove = 220;
const Vec3d kNormal = normalized({0.17, 1, 0.09});

// A step along kNormal, sharp within a texel: the mean and the spread of 8 x 8 x 8 values in each.
ChunkTexelsPtr stepTexels() {
  constexpr int kParts = 8;
  std::vector<std::byte> bytes;
  for (int64_t i = 0; i < volume(kStepDims); ++i) {
    const Vec3i texel{i % kStepDims.x, i / kStepDims.x % kStepDims.y,
                      i / (kStepDims.x * kStepDims.y)};
    int above = 0;
    for (int part = 0; part < kParts * kParts * kParts; ++part) {
      const Vec3d within{part % kParts + 0.5, part / kParts % kParts + 0.5,
                         part / (kParts * kParts) + 0.5};
      const Vec3d from_middle = toDouble(texel) + within / kParts - toDouble(kStepDims) / 2;
      above += dot(from_middle, kNormal) < 0 ? 1 : 0;
    }
    const double share = above / std::pow(kParts, 3);
    for (const double number :
         {std::lerp(kBelow, kAbove, share), 2 * std::sqrt(share * (1 - share)) * (kAbove - kBelow)})
      bytes.push_back(static_cast<std::byte>(std::lround(number)));
  }
  auto chunk = std::make_shared<ChunkTexels>(*chunkTexels(kStepDims, DeviceType::kU8, bytes));
  chunk->has_spread = true;
  return chunk;
}

// Looks at the step from above; values beyond its middle are opaque and of one colour.
FrameSetup setupFromAbove() {
  VolumeLayout layout;
  layout.dims = kStepDims;
  FrameOptions options;
  options.camera.azimuth_deg = 20;
  options.camera.elevation_deg = 75;
  options.size = {64, 64};
  options.step_vox = 0.25;
  const TransferFunction transfer{
      {{0, {0.8, 0.8, 0.8}}, {255, {0.8, 0.8, 0.8}}}, {{110, 0}, {150, 0.9}}, "t"};
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, kStepRange), map, options);
  setup.type = DeviceType::kU8;
  setup.lit = true;
  LookUp look_up = *setup.look_up;
  look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(look_up, kStepRange));
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  return setup;
}

// The standard deviation of the brightness over its mean in the middle of the picture.
double unevenness(Device& device, Vec3d scale) {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kStepDims - Vec3i{1, 1, 1});
  box.texels.scale = scale;
  box.texels.offset = (Vec3d{1, 1, 1} - scale) * 11.5;
  const FrameSetup setup = setupFromAbove();
  const Picture drawn = drawOneBox(device, setup, stepTexels(), box);
  double sum = 0, squares = 0;
  int count = 0;
  for (int y = 24; y < 40; ++y)
    for (int x = 24; x < 40; ++x) {
      const float* rgba = &drawn.rgba[4 * static_cast<size_t>(y * drawn.width + x)];
      EXPECT_GT(rgba[3], 0.9);
      const double bright = double{rgba[0]} / double{rgba[3]};
      sum += bright;
      squares += bright * bright;
      ++count;
    }
  const double mean = sum / count;
  return std::sqrt(squares / count - mean * mean) / mean;
}

TEST(WideTexels, sharpEdgesHaveNoRings) {
  PlainDevice plain;
  const std::unique_ptr<Device> device = suiteDevice();
  for (Device* each : {device.get(), static_cast<Device*>(&plain)})
    for (const double scale : {0.5, 0.4, 0.25})
      EXPECT_LT(unevenness(*each, {scale, scale, scale}), 0.025) << each->backend() << scale;
}

}  // namespace
}  // namespace sluice
