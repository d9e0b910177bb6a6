// DeviceReader: boxes of a source's voxels in device form, the way that level 2, the min-max arrays
// and the growing boxes all read.
//
// If device voxels are as large as stored ones, they are converted in place. If they are smaller
// (doubles), they pass through scratch memory in slabs of planes, which is kept from read to read.
// A reader is used by one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/memory/aligned_array.h"
#include "src/base/sources/volume_source.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

class DeviceReader {
 public:
  static constexpr size_t kScratchBytes = size_t{256} << 10;

  // The scratch takes at most `scratch_bytes`, or one plane of a box. `source` must outlive it.
  explicit DeviceReader(VolumeSource& source, size_t scratch_bytes = kScratchBytes)
      : source_(source), scratch_bytes_(scratch_bytes) {}

  // Fills each region's `out`, x fastest. Throws what the source does. Requires: `out` has
  // box.count() device voxels.
  void read(int64_t time, std::span<const RegionRead> regions);
  void read(int64_t time, const RegionRead& region) { read(time, std::span(&region, 1)); }

  // Time spent since construction.
  int64_t readNs() const { return read_ns_; }
  int64_t convertNs() const { return convert_ns_; }

 private:
  void readInPlace(int64_t time, std::span<const RegionRead> regions);
  void readThroughScratch(int64_t time, std::span<const RegionRead> regions);

  VolumeSource& source_;
  const size_t scratch_bytes_;
  size_t scratch_size_ = 0;
  AlignedArray<std::byte> scratch_;
  int64_t read_ns_ = 0, convert_ns_ = 0;
};

}  // namespace sluice
