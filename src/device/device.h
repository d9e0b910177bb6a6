// Device: the narrow interface behind which something draws (design, "Devices").
//
// A device knows chunks of texels, boxes and slices; it knows nothing of volumes, thresholds or
// budgets. The texture cache model decides which chunks are resident, and the device obeys. Calls
// come from one thread, in this order: beginFrame, then makeResident / evict / draw in any mix,
// boxes front to back, then endFrame or cancelFrame.
//
// The folder: here, the interface and the values that it takes. shading/ defines how a sample looks
// and pictures/ how pictures are made of samples, alike for all devices.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/stop_token.h"
#include "src/base/values/picture.h"
#include "src/device/chunk_texels.h"
#include "src/device/frame_values.h"
#include "src/device/pictures/partial_picture.h"
#include "src/device/view_values.h"

namespace sluice {

// The memory that holds the texels of resident chunks.
enum class TexelPlace {
  kOnDevice,  // copied to memory of the device's own
  kInMemory,  // copied within the process's memory, as software GL does
  kBorrowed,  // not copied: the device holds the texels that it was given
};

struct DeviceLimits {
  int64_t max_picture_size = 0;  // pixels along an axis
  TexelPlace texels = TexelPlace::kOnDevice;
};

// Throws Error for a picture that is larger than the device draws.
inline void requirePictureSize(const PictureSize& size, const DeviceLimits& limits) {
  if (std::max(size.width, size.height) > limits.max_picture_size)
    failRequest("--size {}x{}: this device draws at most {} pixels along an axis; give less",
                size.width, size.height, limits.max_picture_size);
}

// Bytes of textures that a copying device may keep in addition to the resident ones, of which at
// most `resident_bytes` were in use at once. They let it upload into storage that nothing draws
// from any more: enough for chunks of two sizes to take turns. In the process's memory they count
// against --memory.
constexpr uint64_t spareTextureBytes(uint64_t resident_bytes) {
  return std::max(uint64_t{8} << 20, resident_bytes / 2);
}

// A device that borrows may make tables of the resident chunks in the process's memory, which count
// against --memory: two texels and a byte for each brick of so many cells a side.
inline constexpr int64_t kTableBrickSide = 4;

class Device {
 public:
  virtual ~Device() = default;

  // The first chunk id of a user of the device; ranges keep the sessions of a device from meaning
  // each other's chunks. Each user has 2^40.
  uint64_t takeIdRange() { return id_ranges_taken_++ << 40; }

  virtual DeviceLimits limits() const = 0;
  // "osmesa" and the renderer's own name, for reports.
  virtual const char* backend() const = 0;
  virtual const char* renderer() const = 0;

  // Takes a chunk under `id`: whole pages, with the texels around all cells that are to be drawn of
  // it (TexelMap). A device that copies is through with the texels when this returns; one that
  // borrows holds them until the chunk is evicted. Requires: id is not resident.
  virtual void makeResident(uint64_t id, ChunkTexelsPtr texels) = 0;
  // First draws the boxes of this chunk that it has put off; if that throws, as draw() does, the
  // chunk is still resident. Requires: id is resident. A device that copies may keep the storage
  // for another chunk of the same size.
  virtual void evict(uint64_t id) = 0;
  // Bytes of texels copied since construction, counted at the copy; 0 for a device that borrows.
  virtual uint64_t uploadedBytes() const = 0;
  // How often drawing changed from one chunk to another since construction.
  virtual uint64_t binds() const = 0;

  // `stop` is asked while the frame is drawn: draw(), leastOpacity(), stopOpaque(), endFrame() and
  // endPart() throw Interrupted within a fraction of a second once it is set, and cancelFrame()
  // follows.
  virtual void beginFrame(const FrameSetup& setup, const StopToken& stop = {}) = 0;
  // Resamples boxes of resident chunks, front to back, behind all drawn before. The device may do
  // it when it likes, before it evicts one of these chunks and before leastOpacity(), stopOpaque()
  // and endFrame(): the longer the lists, the freer it is.
  virtual void draw(std::span<const BoxDraw> boxes) = 0;
  // For each cell of the grid, row after row, the least opacity that was drawn so far into a pixel
  // whose ray meets the cell; 1 if no pixel's does, 0 if the cell reaches to the eye. It may be
  // less than the true opacity, but never more. Composite only.
  virtual std::vector<float> leastOpacity(const MapGrid& grid) = 0;
  // From now on pixels that have reached FrameSetup::opacity_threshold take no more samples.
  // Composite only.
  virtual void stopOpaque() = 0;
  // Exactly how many samples draw() of these boxes takes over all pixels; their chunks need not be
  // resident. Leaves the picture alone. Must not be called between beginFrame and endFrame.
  virtual uint64_t countSamples(std::span<const BoxDraw> boxes) = 0;
  // After endFrame(): how many samples the frame took, fewer than countSamples() of its boxes if
  // rays ended early, leapt, or pixels were stopped. Requires: setup.counts_taken.
  virtual uint64_t takenSamples() = 0;
  // Waits for the drawing to finish; premultiplied.
  virtual Picture endFrame() = 0;
  // Whether frames with setup.is_part are drawn layer by layer and end with endPart() instead of
  // endFrame(). leastOpacity() and stopOpaque() are not called in such a frame.
  virtual bool drawsParts() const { return false; }
  virtual PartialPicture endPart() { return {}; }
  // The frame is not wanted any more: boxes that were put off are dropped. Chunks stay resident.
  // May be called after a beginFrame() that threw, and if no frame is under way.
  virtual void cancelFrame() = 0;

  // A picture of endFrame()'s that is not needed any more: the next one is written over it, and
  // takes no memory that the kernel has to clear first.
  void reuse(Picture picture) { spare_ = std::move(picture); }

 protected:
  Picture spare_;

 private:
  uint64_t id_ranges_taken_ = 0;
};

}  // namespace sluice
