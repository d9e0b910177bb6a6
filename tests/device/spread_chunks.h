// Chunks whose texels stand for many values, and frames that are drawn of them.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/draw_one_box.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice::spread_chunks {

inline constexpr Vec3i kDims{23, 19, 17};
inline constexpr ValueRange kRange{0, 255};

struct Texel {
  double mean = 0, spread = 0;
};
using TexelAt = std::function<Texel(int64_t)>;  // by its number

// Two numbers a texel, or the means alone.
inline ChunkTexelsPtr chunkOf(const TexelAt& texel_at, DeviceType type, bool has_spread) {
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

inline Texel noiseAt(int64_t i) {
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

inline FrameSetup setupOf(const Seen& seen, DeviceType type) {
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

inline Picture drawOn(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& chunk,
                      Vec3d scale = {1, 1, 1}) {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kDims - Vec3i{1, 1, 1});
  box.texels.scale = scale;
  box.texels.offset = (Vec3d{1, 1, 1} - scale) * 3.0;
  return drawOneBox(device, setup, chunk, box);
}

inline double worstOf(const Picture& a, const Picture& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i)
    worst = std::max(worst, std::abs(255.0 * a.rgba[i] - 255.0 * b.rgba[i]));
  return worst;
}
inline double mostOpacity(const Picture& picture) {
  float most = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) most = std::max(most, picture.rgba[i]);
  return most;
}

inline std::vector<Seen> composites() {
  std::vector<Seen> result;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const bool is_opaque : {false, true})
      for (const auto& [lit, with_gradients] :
           {std::pair{false, false}, {true, false}, {false, true}, {true, true}})
        result.push_back({projection, Mode::kComposite, lit, with_gradients, is_opaque});
  return result;
}

inline constexpr DeviceType kTypes[] = {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32};

class SpreadTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static inline std::unique_ptr<Device> device_;
};

}  // namespace sluice::spread_chunks
