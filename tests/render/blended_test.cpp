// Several channels blended as one medium, against the rule of FrameSetup::others in plain double
// loops over the pixels and the slices, on each device.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "src/render/session/blended_frame.h"
#include "tests/device/suite_device.h"
#include "tests/render/blended_plainly.h"
#include "tests/render/render_scene.h"
#include "tests/support/reference_values.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{44, 40, 36};

// A ball that ends before the volume does, so that no sample lies next to a face.
template <class T>
std::unique_ptr<MemorySource> ball(Vec3d center, double radius, double brightest) {
  return makeMemorySource<T>(kDims, [=](int64_t x, int64_t y, int64_t z) {
    const Vec3d away = toDouble(Vec3i{x, y, z}) - center;
    return std::max(0.0, brightest * (1 - dot(away, away) / (radius * radius)));
  });
}

struct Channel {
  std::unique_ptr<MemorySource> source;
  TransferFunction transfer;
};

TransferFunction look(std::vector<ColorPoint> colors, std::vector<OpacityPoint> opacities) {
  return {.colors = std::move(colors), .opacities = std::move(opacities), .name = "channel"};
}

// Two types of voxels, two balls that meet and one behind them.
std::vector<Channel> threeChannels() {
  std::vector<Channel> channels;
  channels.push_back({ball<uint8_t>({18, 20, 18}, 13, 250),
                      look({{0, {1, 0.2, 0}}, {250, {1, 0.9, 0}}}, {{20, 0}, {250, 0.3}})});
  channels.push_back(
      {ball<uint8_t>({26, 18, 20}, 12, 200),
       look({{0, {0, 0, 1}}, {200, {0.2, 0.6, 1}}}, {{30, 0}, {100, 0.2}, {200, 0}})});
  channels.push_back({ball<uint16_t>({22, 24, 24}, 9, 3000),
                      look({{0, {0, 1, 0}}, {3000, {0, 0.7, 0.1}}}, {{500, 0}, {3000, 0.9}})});
  return channels;
}

FloatPicture blendedPlainly(const std::vector<Channel>& channels, const View& view) {
  std::vector<PlainChannel> plain;
  for (const Channel& channel : channels) {
    const auto values = std::make_shared<const ReferenceValues>(*channel.source, 0);
    plain.push_back({[values](Vec3d p) { return values->at(p); }, channel.transfer});
  }
  return blendedPlainly(plain, kDims, view);
}

// The picture that the sessions draw, with the reports of all channels.
FloatPicture blended(const std::vector<Channel>& channels, const SceneOptions& scene,
                     const FrameOptions& options, std::vector<FrameReport>& reports) {
  const std::unique_ptr<Device> device = suiteDevice();
  std::vector<std::unique_ptr<RenderScene>> scenes;
  std::vector<Session*> sessions;
  for (const Channel& channel : channels) {
    scenes.push_back(
        std::make_unique<RenderScene>(*device, *channel.source, channel.transfer, scene));
    sessions.push_back(&scenes.back()->session());
    sessions.back()->setOptions(options);
  }
  const Picture drawn = blendedFrame(Session::parts(sessions), *device, reports).picture;
  // Again, from warm levels.
  const Picture again = blendedFrame(Session::parts(sessions), *device, reports).picture;
  EXPECT_EQ(drawn.rgba, again.rgba);
  FloatPicture picture;
  picture.width = drawn.width;
  picture.height = drawn.height;
  picture.rgba = drawn.rgba;
  return picture;
}

TEST(Blended, isTheRuleInPlainLoops) {
  const std::vector<Channel> channels = threeChannels();
  FrameOptions options;
  options.size = {61, 47};
  options.camera.azimuth_deg = 35;
  options.camera.elevation_deg = 20;
  for (const Projection projection : kProjections)
    for (const double step : {1.0, 0.6}) {
      options.camera.projection = projection;
      options.step_vox = step;
      const FloatPicture plain = blendedPlainly(
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

TEST(Blended, stopsAtOnceAndDrawsTheNextFrame) {
  const std::vector<Channel> channels = threeChannels();
  const std::unique_ptr<Device> device = suiteDevice();
  std::vector<std::unique_ptr<RenderScene>> scenes;
  std::vector<Session*> sessions;
  FrameOptions options;
  options.size = {40, 30};
  int looks = 0;
  options.watch = [&](uint64_t done, uint64_t) {
    if (++looks == 2 && done > 0) throw std::runtime_error("enough");
  };
  for (const Channel& channel : channels) {
    scenes.push_back(std::make_unique<RenderScene>(*device, *channel.source, channel.transfer,
                                                   SceneOptions{.block_vox = 8, .pages = 4}));
    sessions.push_back(&scenes.back()->session());
    sessions.back()->setOptions(options);
  }
  std::vector<FrameReport> reports;
  EXPECT_THROW(blendedFrame(Session::parts(sessions), *device, reports), std::runtime_error);
  for (Session* session : sessions) {
    options.watch = {};
    session->setOptions(options);
  }
  const Frame frame = blendedFrame(Session::parts(sessions), *device, reports);
  FloatPicture picture;
  picture.width = frame.picture.width;
  picture.height = frame.picture.height;
  picture.rgba = frame.picture.rgba;
  const View view =
      resolve(options.camera, channels.front().source->layout(), options.size, options.step_vox);
  EXPECT_TRUE(within(1, picture, blendedPlainly(channels, view)));
}

}  // namespace
}  // namespace sluice
