// Device: the narrow interface behind which something draws (design, "Devices").
//
// A device knows chunks of texels, boxes and slices; it knows nothing of volumes, thresholds or
// budgets. The texture cache model decides what is resident, the device obeys. Calls come from one
// thread, in this order: beginFrame, then makeResident / evict / draw in any mix, boxes front to
// back, then endFrame.
//
// Index space: positions in voxels, voxel (i, j, k) at (i, j, k). A pixel's ray in index space is
//   p(k) = origin + (k + 1/2) * step  at slice k, with
//   origin = origin0 + x * origin_dx + y * origin_dy,   step = step0 + x * step_dx + y * step_dy
// for pixel (x, y), y upwards from the lower left, at its centre (x + 1/2, y + 1/2). Both parallel
// and perspective views have this form. A box is half-open along the ray: of two boxes that share a
// face, exactly one takes each sample, because both compute the face's slice from the same numbers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "io/picture.h"
#include "src/base/vec.h"
#include "src/render/camera.h"
#include "src/render/lighting.h"
#include "src/volume/device_voxel.h"

namespace sluice {

enum class Mode { kComposite, kMip, kMinip, kAverage };

// See the top: the rays of a view in index space.
struct RayGrid {
  Vec3d origin0, origin_dx, origin_dy;
  Vec3d step0, step_dx, step_dy;
};

// Keeps index positions p with dot(normal, p) <= offset.
struct ClipPlane {
  Vec3d normal;
  double offset = 0;
};

// What a value looks like, ready to be looked up: entry e of `rgba` is for device values around
// lo + e * (hi - lo) / (entries - 1); a sample takes the nearest entry, clamped, or interpolates.
struct LookUp {
  ValueRange device_range;
  bool interpolates = false;
  // r, g, b not premultiplied; opacity of one unit length, not corrected for the step. In modes
  // other than composite a sample takes part where the opacity is above 0; towards the last entries
  // before one of opacity 0 its part fades, so that rounding at an end of what is visible changes
  // a picture by little.
  std::vector<float> rgba;
  // Composite only: the opacity is multiplied by a factor that depends on the gradient's magnitude,
  // see lighting.h. Row r of `factors` is for magnitudes[r], device values a world unit, and has
  // one factor, or one an entry; linear between rows and entries, constant beyond. Empty: no
  // factor. Otherwise chunks carry a ghost layer around each block.
  std::vector<double> magnitudes = {};
  std::vector<float> factors = {};
};

struct FrameSetup {
  PictureSize size;
  Projection projection = Projection::kOrtho;
  RayGrid rays;
  // Rows x, y and w of clip space, from (index position, 1).
  std::array<std::array<double, 4>, 3> clip_from_index{};
  int64_t first_slice = 0;                 // slices below lie behind the eye
  double first_depth = 0, depth_step = 1;  // world depth of slice k: first + (k + 1/2) * step
  // Unit lengths between samples: this for a parallel view; for a perspective one times the length
  // of (u tan_half.x, v tan_half.y, 1), u and v from -1 to 1. Opacity is corrected by it.
  double slice_length = 1;
  double tan_half_x = 0, tan_half_y = 0;
  DeviceType type = DeviceType::kU8;
  LookUp look_up;
  Mode mode = Mode::kComposite;
  double opacity_threshold = 1;      // a ray ends inside a box at this opacity; 1: never
  bool with_depth = false;           // composite only: the picture gets a depth channel
  bool counts_taken = false;         // composite only, not with depth: takenSamples() can be asked
  bool shades_every_sample = false;  // see FrameOptions
  bool lit = false;                  // composite only: chunks carry a ghost layer around each block
  Lighting lighting;
  // Camera-space direction (right, up, toward the viewer) of one device value more a voxel along
  // each index axis: unit axis / spacing.
  std::array<Vec3d, 3> camera_gradient{};
  double flat = 1;                     // device values a world unit, see Lighting
  std::vector<ClipPlane> clip_planes;  // at most kMostClipPlanes
};
inline constexpr size_t kMostClipPlanes = 6;

// A box of cells to resample: p with cells.lo <= p < cells.hi. Texel coordinates of an index
// position p: axis a of the chunk holds p[axes[a]] - texel_origin[a] (texel centres at integers).
struct BoxDraw {
  Box3 cells;
  std::array<int, 3> axes{0, 1, 2};
  Vec3i texel_origin;
};

// A square grid of side x side cells on a plane of index space, seen from the eye: rows x, y and w
// of clip space, from (x, y, 1) in cells; cell (i, j) is [i, i + 1) x [j, j + 1).
struct MapGrid {
  int side = 1;
  std::array<std::array<double, 3>, 3> clip_from_map{};
};

struct DeviceLimits {
  int64_t max_texture_size = 0;     // texels along any axis of a chunk
  int64_t max_picture_size = 0;     // pixels along an axis
  bool textures_in_memory = false;  // software: textures take the process's memory
};

// Textures that a device may keep beside the resident ones, `resident_bytes` at once at the most,
// so that it uploads into storage that nothing draws from any more: enough for chunks of two sizes
// to take turns. On a software device they count against --memory.
constexpr uint64_t spareTextureBytes(uint64_t resident_bytes) {
  return std::max(uint64_t{8} << 20, resident_bytes / 2);
}

class Device {
 public:
  virtual ~Device() = default;

  // Where the chunk ids of one user of the device begin, so that the sessions of a device never
  // mean each other's chunks. Each user has 2^40.
  uint64_t takeIdRange() { return id_ranges_taken_++ << 40; }

  virtual DeviceLimits limits() const = 0;
  // "osmesa" and the renderer's own name, for reports.
  virtual const char* backend() const = 0;
  virtual const char* renderer() const = 0;

  // Uploads a chunk of `storage_vox` texels (whole pages), x fastest, under `id`. Blocks until the
  // bytes are taken over. Requires: id is not resident.
  virtual void makeResident(uint64_t id, Vec3i storage_vox, DeviceType type,
                            std::span<const std::byte> texels) = 0;
  // Requires: id is resident. Its texture is kept for another chunk of the same size.
  virtual void evict(uint64_t id) = 0;
  // Bytes handed to the upload call since construction, counted at that call.
  virtual uint64_t uploadedBytes() const = 0;
  virtual uint64_t binds() const = 0;

  virtual void beginFrame(const FrameSetup& setup) = 0;
  // Resamples boxes that lie in one resident chunk, front to back, behind all drawn before.
  virtual void draw(uint64_t id, std::span<const BoxDraw> boxes) = 0;
  // For each cell of the grid, row after row, the least opacity that was drawn so far into a pixel
  // whose ray meets the cell; 1 where no pixel's does, 0 where the cell reaches to the eye. Never
  // more than that, it may be less. Composite only.
  virtual std::vector<float> leastOpacity(const MapGrid& grid) = 0;
  // From now on pixels that have reached FrameSetup::opacity_threshold take no more samples.
  // Composite only.
  virtual void stopOpaque() = 0;
  // Exactly how many samples draw() of these boxes takes over all pixels. Leaves the picture alone.
  virtual uint64_t countSamples(std::span<const BoxDraw> boxes) = 0;
  // After endFrame(): how many samples the frame took, less than countSamples() says of its boxes
  // where rays ended early or pixels were stopped. Requires: setup.counts_taken.
  virtual uint64_t takenSamples() = 0;
  // Waits for what was drawn; premultiplied.
  virtual Picture endFrame() = 0;

  // A picture of endFrame()'s that is not needed any more: the next one is written over it, and
  // takes no memory that the kernel has to clear first.
  void reuse(Picture picture) { spare_ = std::move(picture); }

 protected:
  Picture spare_;

 private:
  uint64_t id_ranges_taken_ = 0;
};

}  // namespace sluice
