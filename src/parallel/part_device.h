// PartDevice: a rank's own device, made to draw its part of pictures that all ranks draw together.
// The frame that uses it does not know: it draws boxes front to back and ends with a picture, which
// is empty; takePart() returns the part for compositing.h.
//
// A device that draws parts (Device::drawsParts()) gets each box's layer. For any other device,
// such as OpenGL's, the boxes are put off and drawn one layer after another, each as a picture of
// its own. The opacity reached on the device is that of one part alone, so it hides nothing
// (leastOpacity() returns 0). Used on one thread, the device's.
#pragma once

#include <memory>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "src/device/device.h"
#include "src/parallel/dealing.h"

namespace sluice {

class PartDevice : public Device {
 public:
  PartDevice(std::unique_ptr<Device> device, const Dealing& dealing);

  // The hands of later frames.
  void deal(const Dealing& dealing) { dealing_ = dealing; }

  // Later frames are whole pictures of the boxes drawn, as the device alone makes them.
  void drawWhole(bool whole) { draws_whole_ = whole; }
  // Parts of a frame take no more than this: beyond it drawing throws Error.
  void limitPart(uint64_t most_bytes) { most_bytes_ = most_bytes; }
  // The part that the last frame drew; its setup is setup(). To be taken once a frame.
  PartialPicture takePart() { return std::exchange(part_, {}); }
  const FrameSetup& setup() const { return setup_; }

  DeviceLimits limits() const override { return device_->limits(); }
  const char* backend() const override { return device_->backend(); }
  const char* renderer() const override { return device_->renderer(); }
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override;
  void evict(uint64_t id) override;
  uint64_t uploadedBytes() const override { return device_->uploadedBytes(); }
  uint64_t binds() const override { return device_->binds(); }
  void beginFrame(const FrameSetup& setup, const StopToken& stop = {}) override;
  void draw(std::span<const BoxDraw> boxes) override;
  std::vector<float> leastOpacity(const MapGrid& grid) override;
  void stopOpaque() override;
  uint64_t countSamples(std::span<const BoxDraw> boxes) override;
  uint64_t takenSamples() override;
  Picture endFrame() override;
  void cancelFrame() override;

 private:
  bool goesByLayers() const { return !draws_whole_ && !device_->drawsParts(); }
  // Draws the boxes that were put off, on a device that does not draw parts.
  void drawPutOff();
  void takeLayer(uint32_t layer, const Picture& picture);

  const std::unique_ptr<Device> device_;
  Dealing dealing_;
  bool draws_whole_ = false;
  uint64_t most_bytes_ = UINT64_MAX;
  FrameSetup setup_;
  StopToken stop_;
  std::optional<DealingLayers> layers_;
  std::vector<BoxDraw> put_off_;
  std::unordered_set<uint64_t> put_off_chunks_;
  uint64_t taken_ = 0, part_bytes_ = 0;
  PartialPicture part_;
};

}  // namespace sluice
