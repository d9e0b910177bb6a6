// Three channels on one grid, and the sessions that draw them blended as one medium.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "src/render/session/blended_frame.h"
#include "tests/render/render_scene.h"

namespace sluice {

inline constexpr Vec3i kBlendedDims{44, 40, 36};

struct BlendedChannel {
  std::unique_ptr<MemorySource> source;
  TransferFunction transfer;
};

// A ball that ends before the volume does, so that no sample lies next to a face.
template <class T>
std::unique_ptr<MemorySource> ball(Vec3d center, double radius, double brightest) {
  return makeMemorySource<T>(kBlendedDims, [=](int64_t x, int64_t y, int64_t z) {
    const Vec3d away = toDouble(Vec3i{x, y, z}) - center;
    return std::max(0.0, brightest * (1 - dot(away, away) / (radius * radius)));
  });
}

inline TransferFunction channelLook(std::vector<ColorPoint> colors,
                                    std::vector<OpacityPoint> opacities) {
  return {.colors = std::move(colors), .opacities = std::move(opacities), .name = "channel"};
}

// Two types of voxels, two balls that meet and one behind them.
inline std::vector<BlendedChannel> threeChannels() {
  std::vector<BlendedChannel> channels;
  channels.push_back({ball<uint8_t>({18, 20, 18}, 13, 250),
                      channelLook({{0, {1, 0.2, 0}}, {250, {1, 0.9, 0}}}, {{20, 0}, {250, 0.3}})});
  channels.push_back(
      {ball<uint8_t>({26, 18, 20}, 12, 200),
       channelLook({{0, {0, 0, 1}}, {200, {0.2, 0.6, 1}}}, {{30, 0}, {100, 0.2}, {200, 0}})});
  channels.push_back(
      {ball<uint16_t>({22, 24, 24}, 9, 3000),
       channelLook({{0, {0, 1, 0}}, {3000, {0, 0.7, 0.1}}}, {{500, 0}, {3000, 0.9}})});
  return channels;
}

// A session for each channel, on one device. The references must outlive it.
class BlendedScene {
 public:
  BlendedScene(Device& device, const std::vector<BlendedChannel>& channels,
               const SceneOptions& options)
      : device_(device) {
    for (const BlendedChannel& channel : channels) {
      scenes_.push_back(
          std::make_unique<RenderScene>(device, *channel.source, channel.transfer, options));
      sessions_.push_back(&scenes_.back()->session());
    }
  }

  const std::vector<Session*>& sessions() const { return sessions_; }
  void setOptions(const FrameOptions& options) {
    for (Session* session : sessions_) session->setOptions(options);
  }
  // The next frame; `reports` are set to those of all channels.
  FloatPicture draw(std::vector<FrameReport>& reports) {
    Picture drawn = blendedFrame(Session::parts(sessions_), device_, reports).picture;
    return {drawn.width, drawn.height, std::move(drawn.rgba), std::move(drawn.depth)};
  }

 private:
  Device& device_;
  std::vector<std::unique_ptr<RenderScene>> scenes_;
  std::vector<Session*> sessions_;
};

}  // namespace sluice
