// Several channels blended as one medium, against the rule of FrameSetup::others in plain double
// loops over the pixels and the slices, on each device.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/device/suite_device.h"
#include "tests/render/blended_plainly.h"
#include "tests/render/blended_scene.h"
#include "tests/support/reference_values.h"

namespace sluice {
namespace {

FloatPicture plainlyBlended(const std::vector<BlendedChannel>& channels, const View& view) {
  std::vector<PlainChannel> plain;
  for (const BlendedChannel& channel : channels) {
    const auto values = std::make_shared<const ReferenceValues>(*channel.source, 0);
    plain.push_back({[values](Vec3d p) { return values->at(p); }, channel.transfer});
  }
  return blendedPlainly(plain, kBlendedDims, view);
}

// The picture that the sessions draw, with the reports of all channels.
FloatPicture blended(const std::vector<BlendedChannel>& channels, const SceneOptions& options,
                     const FrameOptions& frame, std::vector<FrameReport>& reports) {
  const std::unique_ptr<Device> device = suiteDevice();
  BlendedScene scene(*device, channels, options);
  scene.setOptions(frame);
  FloatPicture picture = scene.draw(reports);
  // Again, from warm levels.
  EXPECT_EQ(scene.draw(reports).rgba, picture.rgba);
  return picture;
}

TEST(Blended, isTheRuleInPlainLoops) {
  const std::vector<BlendedChannel> channels = threeChannels();
  FrameOptions options;
  options.size = {61, 47};
  options.camera.azimuth_deg = 35;
  options.camera.elevation_deg = 20;
  for (const Projection projection : kProjections)
    for (const double step : {1.0, 0.6}) {
      options.camera.projection = projection;
      options.step_vox = step;
      const FloatPicture plain = plainlyBlended(
          channels, resolve(options.camera, channels.front().source->layout(), options.size, step));
      EXPECT_GT(shownShare(plain), 0.08);
      for (const SceneOptions& scene :
           {SceneOptions{.block_vox = 16}, SceneOptions{.block_vox = 8},
            // A page is a block of 8, and a cluster two of them.
            SceneOptions{.block_vox = 8, .pages = 2}, SceneOptions{.block_vox = 64}}) {
        std::vector<FrameReport> reports;
        EXPECT_TRUE(within(1, blended(channels, scene, options, reports), plain))
            << scene.block_vox << " " << scene.pages << " " << step;
        ASSERT_EQ(reports.size(), channels.size());
        for (const FrameReport& report : reports) EXPECT_GT(report.boxes_drawn, 0);
      }
    }
}

// Several pixels a voxel: the rays of a packet meet the same few texels. Views along the axes have
// samples on voxel planes, and the channels' boxes have different shapes and orders of texels.
TEST(Blended, isTheRuleCloseUp) {
  const std::vector<BlendedChannel> channels = threeChannels();
  FrameOptions options;
  options.size = {126, 117};
  for (const Projection projection : kProjections)
    for (const auto& [azimuth, elevation] :
         {std::pair{0.0, 0.0}, {90.0, 0.0}, {180.0, 90.0}, {215.0, -50.0}}) {
      options.camera.projection = projection;
      options.camera.azimuth_deg = azimuth;
      options.camera.elevation_deg = elevation;
      const FloatPicture plain = plainlyBlended(
          channels, resolve(options.camera, channels.front().source->layout(), options.size, 1));
      for (const int64_t block_vox : {8, 64}) {
        std::vector<FrameReport> reports;
        EXPECT_TRUE(within(1, blended(channels, {.block_vox = block_vox}, options, reports), plain))
            << block_vox << " " << azimuth;
      }
    }
}

// Channels that show in the same cells: the CPU device reads their samples together, four at once.
std::vector<BlendedChannel> channelsAlike(int count) {
  std::vector<BlendedChannel> channels;
  for (int c = 0; c < count; ++c) {
    auto waves = makeMemorySource<uint8_t>(kBlendedDims, [c](int64_t x, int64_t y, int64_t z) {
      const Vec3d at = toDouble(Vec3i{x, y, z}), away = at - Vec3d{22, 20, 18};
      if (dot(away, away) > 14 * 14) return 0.0;
      return 170 + 70 * std::sin(dot(at, Vec3d{0.3 + 0.3 * c, 0.5, -0.2 * c}));
    });
    const double part = c / 5.0;
    channels.push_back({std::move(waves), channelLook({{0, {part, 0, 1}}, {250, {1, 1 - part, 0}}},
                                                      {{90, 0}, {250, 0.1 * part + 0.02}})});
  }
  return channels;
}

TEST(Blended, isTheRuleWhereAllChannelsShow) {
  FrameOptions options;
  options.size = {126, 117};
  options.camera.azimuth_deg = 35;
  options.camera.elevation_deg = 20;
  for (const int count : {2, 3, 5}) {
    const std::vector<BlendedChannel> channels = channelsAlike(count);
    for (const Projection projection : kProjections) {
      options.camera.projection = projection;
      const FloatPicture plain = plainlyBlended(
          channels, resolve(options.camera, channels.front().source->layout(), options.size, 1));
      EXPECT_GT(shownShare(plain), 0.08);
      for (const int64_t block_vox : {8, 64}) {
        std::vector<FrameReport> reports;
        EXPECT_TRUE(within(1, blended(channels, {.block_vox = block_vox}, options, reports), plain))
            << block_vox << " " << count;
      }
    }
  }
}

TEST(Blended, stopsAtOnceAndDrawsTheNextFrame) {
  const std::vector<BlendedChannel> channels = threeChannels();
  const std::unique_ptr<Device> device = suiteDevice();
  FrameOptions options;
  options.size = {40, 30};
  int looks = 0;
  options.watch = [&](uint64_t done, uint64_t) {
    if (++looks == 2 && done > 0) throw std::runtime_error("enough");
  };
  BlendedScene scene(*device, channels, {.block_vox = 8, .pages = 4});
  scene.setOptions(options);
  std::vector<FrameReport> reports;
  EXPECT_THROW(scene.draw(reports), std::runtime_error);
  options.watch = {};
  scene.setOptions(options);
  const View view = resolve(options, channels.front().source->layout());
  EXPECT_TRUE(within(1, scene.draw(reports), plainlyBlended(channels, view)));
}

}  // namespace
}  // namespace sluice
