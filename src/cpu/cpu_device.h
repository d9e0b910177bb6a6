// CpuDevice: the Device that draws with the processor's own vector instructions, for machines
// without a GPU. It borrows the texels of resident chunks (no copy), puts boxes off until there are
// many, sorts them into tiles of the picture, front to back, and draws the tiles on the threads of
// a pool: a packet of pixels goes through a box together, a lane a pixel.
//
// The way of a box: draw() -> kernel_box.h (single precision, the pixels that may see it) ->
// tile_bins.h -> composite_kernels.cpp, blended_kernels.cpp or mode_kernels.cpp (sample
// positions: rays.inl; their values: texels.inl; their colours: colors.inl) -> tiled_picture.h, or
// tile_parts.h for a part of a picture.
//
// The folder: here, the device, its tiles, and what it makes of chunks and lights before it draws
// (leap_grid.h, light_squares.h). kernels/ has the code that is compiled for each instruction set,
// and the values that it reads.
//
// Called by one thread; the pool's threads work inside the calls.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/cpu/kernels/kernel_frame.h"
#include "src/cpu/leap_grid.h"
#include "src/cpu/light_squares.h"
#include "src/cpu/simd_target.h"
#include "src/cpu/tile_bins.h"
#include "src/cpu/tile_parts.h"
#include "src/cpu/tiled_picture.h"
#include "src/device/device.h"
#include "src/device/pictures/added_frames.h"
#include "src/device/pictures/picture_rows.h"

namespace sluice {

// Boxes of a tile between two looks whether to stop.
inline constexpr size_t kBoxesBetweenStops = 256;
// body(tile) for each, until one throws. A thread begins with the tiles that it had in the last
// frame, whose pixels and texels its caches may hold, and then helps the others.
void eachTile(WorkerPool& pool, int64_t tiles, const std::function<void(int64_t tile)>& body);

class CpuDevice : public Device, public DrawsRows, public AddsFrames {
 public:
  // `pool` must outlive the device. Throws Error if the processor lacks the target.
  explicit CpuDevice(WorkerPool& pool, SimdTarget target = SimdTarget::kAuto);

  DeviceLimits limits() const override;
  const char* backend() const override { return "cpu"; }
  const char* renderer() const override { return renderer_.c_str(); }  // "SIMD avx512, 2 threads"
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override;
  void evict(uint64_t id) override;
  uint64_t uploadedBytes() const override { return 0; }
  uint64_t binds() const override { return binds_; }
  void beginFrame(const FrameSetup& setup, const StopToken& stop = {}) override;
  void draw(std::span<const BoxDraw> boxes) override;
  std::vector<float> leastOpacity(const MapGrid& grid) override;
  void stopOpaque() override;
  uint64_t countSamples(std::span<const BoxDraw> boxes) override;
  uint64_t takenSamples() override;
  Picture endFrame() override;
  bool drawsParts() const override { return true; }
  PartialPicture endPart() override;
  void cancelFrame() override { forgetPutOff(); }
  void drawRows(std::optional<PictureRows> rows) override { rows_ = rows; }
  std::optional<PictureRows> rows() const override { return rows_; }
  void beginSum() override;
  Sum endSum(float least_opacity) override;
  void cancelSum() override;

 private:
  struct Leaps {
    std::optional<LeapGrid> grid;  // once the chunk was drawn
    uint64_t made_for = 0;         // which `shown_number_` its distances are of
  };
  struct Resident {
    ChunkTexelsPtr texels;
    bool is_put_off = false;  // boxes of it are
    Leaps leaps;
    uint32_t channel = 0;  // of its boxes
  };
  // A chunk that was evicted comes back with the same texels if it is still in the level below, as
  // when a threshold goes to and fro.
  struct Evicted {
    std::weak_ptr<const ChunkTexels> texels;
    Leaps leaps;
  };

  // The look of a channel, for the last frame.
  struct ChannelLook {
    std::optional<LookUpTables> look_up;
    std::optional<FrameTables> tables;  // for the current frame
    ShownValues shown;                  // for the last frame with leaps
    LookUpPtr shown_for;                // look-up behind shown
    uint64_t shown_number = 0;          // counts its changes, and is no other channel's
  };

  // Takes the look of a channel for the frame that begins.
  void takeLook(const FrameSetup& setup, ChannelLook& look);
  // The boxes that were put off, for the kernels.
  std::vector<KernelBox> kernelBoxes() const;
  void forgetPutOff();
  PictureRows rowsOfFrame() const;
  TileBins binsOf(const std::vector<KernelBox>& boxes) const;
  // Whether a tile's pixels are wanted after `then`.
  enum class Keep { kPixels, kNothing };
  // Draws the boxes that were put off. `then` is called for each tile of the picture once it is
  // drawn, by the thread that has its pixels in cache: without colours if the frame has drawn
  // nothing there.
  using Then = std::function<void(const TilePixels& tile)>;
  void drawNow(const Then& then = {}, Keep keep = Keep::kPixels);
  // Makes the leap grids of all chunks whose boxes are put off, on the pool.
  void prepareLeaps();

  WorkerPool& pool_;
  const Kernels& kernels_;
  const std::string renderer_;
  std::unordered_map<uint64_t, Resident> resident_;
  std::unordered_map<const ChunkTexels*, Evicted> evicted_;
  size_t most_evicted_ = 0;  // more than these are looked through
  FrameSetup setup_;
  LightSquares light_squares_;                       // for the last frame that was lit
  std::vector<std::unique_ptr<ChannelLook>> looks_;  // the setup's own first
  uint64_t shown_numbers_ = 0;                       // given to looks
  FrameKernels drawing_;                             // of the current frame
  bool leaps_ = false;                               // the frame does
  StopToken stop_;
  std::optional<PictureRows> rows_;
  TiledPicture picture_;
  TileParts parts_;  // used if the frame is a part
  std::vector<BoxDraw> put_off_;
  double put_off_samples_ = 0;  // about
  // The frames of a sum with their boxes, all of which are put off.
  struct AddedFrames {
    std::vector<FrameSetup> setups;
    std::vector<std::vector<BoxDraw>> boxes;
  };
  std::optional<AddedFrames> sum_;
  std::atomic<uint64_t> taken_ = 0;
  uint64_t binds_ = 0;
};

}  // namespace sluice
