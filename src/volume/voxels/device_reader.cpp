#include "src/volume/voxels/device_reader.h"

#include <algorithm>

#include "src/base/threads/clock.h"

namespace sluice {
namespace {

int64_t lapNs(Stopwatch& watch) {
  return static_cast<int64_t>(watch.lap() * 1e9);
}

}  // namespace

void DeviceReader::read(int64_t time, std::span<const RegionRead> regions) {
  const VolumeLayout& layout = source_.layout();
  if (bytesPerVoxel(layout.type) == bytesPerVoxel(deviceMap(layout).type)) {
    readInPlace(time, regions);
  } else {
    for (const RegionRead& region : regions) readThroughScratch(time, region);
  }
}

void DeviceReader::readInPlace(int64_t time, std::span<const RegionRead> regions) {
  Stopwatch watch;
  source_.readRegions(time, regions);
  read_ns_ += lapNs(watch);
  const VoxelType type = source_.layout().type;
  if (isStoredAsDevice(type)) return;
  for (const RegionRead& region : regions) toDevice(type, region.out, region.out);
  convert_ns_ += lapNs(watch);
}

void DeviceReader::readThroughScratch(int64_t time, const RegionRead& region) {
  // Stored voxels are larger than their place in `out`, so that they come in slabs of planes.
  const VoxelType type = source_.layout().type;
  const Box3& box = region.box;
  const size_t device_bytes = region.out.size() / static_cast<size_t>(box.count());
  const auto plane_voxels = static_cast<size_t>(box.size().x * box.size().y);
  const size_t plane_bytes = plane_voxels * bytesPerVoxel(type);
  const auto planes = std::min<int64_t>(
      static_cast<int64_t>(std::max<size_t>(1, scratch_bytes_ / plane_bytes)), box.size().z);
  if (const size_t bytes = plane_bytes * static_cast<size_t>(planes); bytes > scratch_size_) {
    scratch_.reset();  // never two at once
    scratch_ = alignedForOverwrite<std::byte>(bytes);
    scratch_size_ = bytes;
  }
  Stopwatch watch;
  std::span<std::byte> out = region.out;
  for (int64_t z = box.lo.z; z < box.hi.z; z += planes) {
    const Box3 slab{{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, std::min(z + planes, box.hi.z)}};
    const auto count = static_cast<size_t>(slab.count());
    const std::span stored(scratch_.get(), count * bytesPerVoxel(type));
    source_.readRegion(time, slab, stored);
    read_ns_ += lapNs(watch);
    toDevice(type, stored, out.first(count * device_bytes));
    out = out.subspan(count * device_bytes);
    convert_ns_ += lapNs(watch);
  }
}

}  // namespace sluice
