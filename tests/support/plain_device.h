// PlainDevice: the contract of src/device/ in plain double-precision loops, for tests of whatever
// draws: it needs no driver, is exact, and small pictures take milliseconds. It shares nothing with
// the devices of the program but their interface.
//
// Options take the choices that the contract leaves: a device that holds the texels that it is
// given instead of copying them, and one that draws as late as it may.
#pragma once

#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "src/device/device.h"
#include "tests/support/plain_rays.h"
#include "tests/support/plain_sampling.h"

namespace sluice {

struct PlainDeviceOptions {
  bool borrows = false;
  bool puts_off = false;
};

class PlainDevice : public Device {
 public:
  explicit PlainDevice(const PlainDeviceOptions& options = {}) : options_(options) {}

  DeviceLimits limits() const override {
    return {1 << 14, options_.borrows ? TexelPlace::kBorrowed : TexelPlace::kInMemory};
  }
  const char* backend() const override { return "plain"; }
  const char* renderer() const override { return "plain loops"; }
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override;
  void evict(uint64_t id) override;
  uint64_t uploadedBytes() const override { return uploaded_bytes_; }
  uint64_t binds() const override { return binds_; }
  void beginFrame(const FrameSetup& setup, const StopToken& stop = {}) override;
  void draw(std::span<const BoxDraw> boxes) override;
  std::vector<float> leastOpacity(const MapGrid& grid) override;
  void stopOpaque() override;
  uint64_t countSamples(std::span<const BoxDraw> boxes) override;
  uint64_t takenSamples() override { return taken_; }
  Picture endFrame() override;
  void cancelFrame() override { put_off_.clear(); }

  uint64_t residentBytes() const;
  // Called with each list that comes, before it is drawn, and before each eviction.
  std::function<void(std::span<const BoxDraw>)> on_draw;
  std::function<void()> on_evict;

 private:
  struct Pixel {
    Vec3d rgb;
    double opacity = 0, depth_sum = 0;
    // Other modes: of the samples that took part.
    double value = 0;
    double dimmed = 0;  // attenuated maximum: what is taken from values behind
    double depth = 0;   // depth-coded maximum: of the sample that counts, as FrameSetup has it
    int64_t count = 0;
    bool is_stopped = false;
  };
  // A sample of opacities that a ray takes, and what it blends of it.
  struct Sample {
    Vec3d rgb;
    double opacity = 0, depth = 0;
  };

  // From 0 to 1, see depthCode().
  double placeOfDepth(double depth) const;
  void drawNow();
  // `joined`: the boxes that join it.
  void drawBox(const BoxDraw& box, std::span<const BoxDraw> joined);
  void take(const PlainRay& ray, const BoxDraw& box, const ChunkTexels& chunk, Pixel& pixel);
  void takeValue(const PlainRay& ray, double value, double k, Pixel& pixel) const;
  void blend(const Sample& sample, Pixel& pixel) const;
  void blendSurfaces(const PlainRay& ray, const BoxDraw& box, const ChunkTexels& chunk, double k,
                     const Sample& sample, Pixel& pixel) const;
  Pixel& at(int x, int y) {
    return pixels_[static_cast<size_t>(y) * static_cast<size_t>(setup_.size.width) +
                   static_cast<size_t>(x)];
  }

  const PlainDeviceOptions options_;
  std::unordered_map<uint64_t, ChunkTexelsPtr> resident_;
  uint64_t uploaded_bytes_ = 0, binds_ = 0, taken_ = 0;
  FrameSetup setup_;
  std::optional<MeanLook> mean_look_;  // a frame that integrates
  StopToken stop_;
  std::vector<Pixel> pixels_;  // rows upwards
  std::vector<BoxDraw> put_off_;
  std::span<const BoxDraw> joined_;  // of the box that is drawn
};

// A chunk of these bytes, x fastest.
ChunkTexelsPtr chunkTexels(Vec3i storage_vox, DeviceType type, std::span<const std::byte> bytes);

}  // namespace sluice
