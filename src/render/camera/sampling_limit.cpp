#include "src/render/camera/sampling_limit.h"

#include <algorithm>
#include <vector>

#include "src/base/threads/clock.h"
#include "src/render/camera/frame_setup.h"

namespace sluice {
namespace {

constexpr int64_t kSide = 64;  // texels: 256 KiB, the size of a block of the default page
// A number that no session gives out.
constexpr uint64_t kChunk = UINT64_MAX - 1;
constexpr int kWarmFrames = 2;

// Translucent everywhere, so that no pixel saturates, and no two neighbours alike.
OpacityTable translucent(const ValueMap& map) {
  TransferFunction transfer;
  transfer.colors = {{0, {0.2, 0.4, 0.8}}, {255, {1, 0.9, 0.7}}};
  transfer.opacities = {{0, 0.002}, {255, 0.01}};
  return {transfer, map, {0, 255}};
}

ChunkTexelsPtr texels() {
  auto chunk = std::make_shared<ChunkTexels>();
  chunk->storage_vox = chunk->size_vox = {kSide, kSide, kSide};
  chunk->byte_count = static_cast<size_t>(kSide * kSide * kSide);
  chunk->bytes = std::make_shared<std::byte[]>(chunk->byte_count);
  // A generator of its own: the same texels on all machines.
  uint32_t state = 1;
  for (std::byte& byte : chunk->span()) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::byte>(state >> 24);
  }
  return chunk;
}

}  // namespace

SamplingRate samplingLimit(Device& device, PictureSize size, int frames) {
  VolumeLayout layout;
  layout.dims = {kSide, kSide, kSide};
  const ValueMap map = deviceMap(layout);
  FrameOptions options;
  options.size = size;
  options.camera.azimuth_deg = 30;
  options.camera.elevation_deg = 20;
  options.camera.zoom = 3;  // the cube covers the picture
  options.step_vox = 0.25;
  const View view = resolve(options.camera, layout, size, options.step_vox);
  const FrameSetup setup = frameSetup(view, layout, translucent(map), map, options);
  BoxDraw box;
  box.chunk = kChunk;
  box.cells = boxOf(layout.dims - Vec3i{1, 1, 1});
  device.makeResident(kChunk, texels());
  std::vector<double> seconds, processor_seconds;
  uint64_t samples = 0;
  for (int i = -kWarmFrames; i < frames; ++i) {
    const double processor_before = processorSeconds();
    const Stopwatch watch;
    device.beginFrame(setup);
    device.draw({&box, 1});
    device.reuse(device.endFrame());
    if (i >= 0) {
      seconds.push_back(watch.seconds());
      processor_seconds.push_back(processorSeconds() - processor_before);
    }
    // Counted once, outside the timed frames.
    if (i == -1) samples = device.countSamples({&box, 1});
  }
  device.evict(kChunk);
  const auto rateOf = [samples](std::vector<double>& times) {
    std::ranges::sort(times);
    // The median, since single frames are disturbed by others on the machine.
    return static_cast<double>(samples) / times[times.size() / 2];
  };
  return {rateOf(seconds), rateOf(processor_seconds)};
}

}  // namespace sluice
