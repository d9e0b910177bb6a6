// VolumeSource: the interface of level 1 (disk) to the levels above; one implementation a file
// format.
//
// A source describes a volume on disk and copies boxes of voxels out of it. It holds no cache of
// voxels of its own beyond what its format forces on it (a compressed single stream is decoded once
// into a temporary file). All members may be called from any thread at once after construction.
//
// The folder: what a source tells of its volume (volume_levels.h, volume_channels.h), of the parts
// that it reads at once (read_units.h, stored_reads.h), and how to take part in a pass over its
// voxels (voxel_taker.h).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/values/vec.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

// A closed interval of values.
struct ValueRange {
  double lo = 0, hi = 0;
  friend constexpr bool operator==(const ValueRange&, const ValueRange&) = default;
};

// The meaning of the world's axes for people, as far as the file tells it.
enum class WorldFrame {
  kNone,         // nothing is known
  kRas,          // right, anterior, superior: NIfTI
  kLps,          // left, posterior, superior: DICOM, ITK's files
  kPictureRows,  // x to the right, y down the rows, z through the stack: slices and microscopy
  kYUp,          // computer graphics: OpenVDB
};

// The most voxels of a volume: sums over them, of 8 bytes each, stay within 64 bits.
inline constexpr int64_t kMostVolumeVoxels = int64_t{1} << 59;
// Whether a volume may have this size: a voxel or more along each axis, and no more in all.
constexpr bool isCountable(Vec3i dims) {
  return dims.x >= 1 && dims.y >= 1 && dims.z >= 1 && dims.x <= kMostVolumeVoxels / dims.y &&
         dims.x * dims.y <= kMostVolumeVoxels / dims.z;
}

// Position and meaning of the voxels.
struct VolumeLayout {
  Vec3i dims;                       // voxels, each >= 1
  VoxelType type = VoxelType::kU8;  // type that readRegion delivers, in this machine's byte order
  Vec3d spacing{1, 1, 1};           // world units between neighbouring voxels, each > 0
  Vec3d origin{0, 0, 0};            // world position of voxel (0, 0, 0)
  std::array<Vec3d, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // unit directions of x, y, z
  int64_t time_steps = 1;
  std::optional<ValueRange> stored_range;  // range of stored values, if the file tells it
  double value_scale = 1, value_offset = 0;
  std::string name;  // for people, in reports: the file's name or the grid's
  // The file, folder or store as the user gave it; empty: none was given. Of a series, its first.
  std::string path;
  std::string unit;  // unit of spacing and origin, if the file tells it: "millimeter", ...
  WorldFrame frame = WorldFrame::kNone;
  // False: the file could tell its place and does not.
  bool tells_place = true;
  // For people, one line: why the volume is not at the place that the file tells (place_fault.h),
  // which matters beside another volume. Empty: it is there.
  std::string place_fault;
  // Other contents of the file: the number of channels or components and the one that is read, the
  // number of levels of resolution, the names of all grids or arrays.
  int64_t channels = 1, channel = 0, levels = 1;
  std::vector<std::string> grids;
  // For people, one line each: choices among several, and possible faults that can be read anyway.
  std::vector<std::string> notes;

  // The words that messages call the volume by: several files may have the same name.
  const std::string& calledBy() const { return path.empty() ? name : path; }
};

// A constant outside a list of boxes: known to sparse formats without reading a voxel.
struct Occupancy {
  double background = 0;    // the stored value outside all boxes; of floats perhaps NaN or infinite
  std::vector<Box3> boxes;  // voxels, clipped to the volume; may touch or overlap
};

// A box to be copied out, and its destination.
struct RegionRead {
  Box3 box;
  std::span<std::byte> out;
};

// How a pass over all voxels reads a source fastest.
struct PassReads {
  // The most decoded bytes that are kept, if more only take time: fresh memory for a copy of what
  // the system has in memory anyway.
  uint64_t most_bytes = UINT64_MAX;
  // Threads for each of the pool's, unless it has one: more if threads wait for files most of the
  // time.
  int threads_each = 1;
};

class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  // Constant after construction.
  virtual const VolumeLayout& layout() const = 0;

  // Copies the voxels of `box` at time step `time` to `out`, x fastest, packed, in layout().type.
  // Requires: 0 <= time < time_steps; box not empty and inside [0, dims);
  // out.size() == box.count() * bytesPerVoxel(type). Throws Error when the read fails or is short.
  virtual void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) = 0;

  // Calls readRegion() for each; a source whose voxels lie in rows reads neighbouring regions
  // together. For blocks that lie side by side along x, which share the voxel planes between them.
  virtual void readRegions(int64_t time, std::span<const RegionRead> regions) {
    for (const RegionRead& region : regions) readRegion(time, region.box, region.out);
  }

  // A box (as in readRegion) that will be read soon: a source may begin to fetch it. Returns at
  // once. Throws Error as readRegion does.
  virtual void expectRegion(int64_t /*time*/, const Box3& /*box*/) {}

  // The cells in which voxels may differ from a constant; nullopt: anywhere.
  virtual std::optional<Occupancy> occupancy(int64_t /*time*/) { return std::nullopt; }

  // A line that changes whenever the voxels may have changed: absolute path, size, modification
  // time in ns and whatever else selects the voxels (grid name, dims given by the user). Keys the
  // index.
  virtual std::string identity() const = 0;

  // Every file that the volume is read from: headers, detached voxels, slices, each time step's. A
  // folder stands for all that is in it (a Zarr store). Paths are as the user named them, so
  // perhaps relative to the current folder. May open files to find out; throws Error as opening
  // them does.
  virtual std::vector<std::string> files() { return {}; }

  // The least bytes that a source of compressed chunks keeps decoded while a thread reads; 0: none.
  virtual uint64_t heldBytesAThread() const { return 0; }
  // From now on decoded chunks take at most these bytes, or the least that the threads inside
  // readRegion need, whichever is more.
  virtual void holdAtMost(uint64_t /*bytes*/) {}
  // How a pass over all voxels, layer by layer, should read.
  virtual PassReads passReads() const { return {}; }

  // How many reads should wait at once for a source that answers late, such as a web server; 0: it
  // is near.
  virtual int distantReads() const { return 0; }

  // Bytes taken from files so far by this source (compressed bytes if compressed).
  virtual uint64_t storedBytesRead() const = 0;
};

}  // namespace sluice
