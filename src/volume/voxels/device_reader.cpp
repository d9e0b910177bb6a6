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
    readThroughScratch(time, regions);
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

void DeviceReader::readThroughScratch(int64_t time, std::span<const RegionRead> regions) {
  // Stored voxels are larger than their place in `out`, so that they come in slabs of planes.
  const VoxelType type = source_.layout().type;
  int64_t planes = INT64_MAX, first = INT64_MAX, end = 0;
  size_t most_bytes = 0;
  for (const auto& [box, out] : regions) {
    const size_t plane_bytes =
        static_cast<size_t>(box.size().x * box.size().y) * bytesPerVoxel(type);
    planes =
        std::min(planes, static_cast<int64_t>(std::max<size_t>(1, scratch_bytes_ / plane_bytes)));
    first = std::min(first, box.lo.z);
    end = std::max(end, box.hi.z);
    most_bytes = std::max(most_bytes, plane_bytes);
  }
  planes = std::min(planes, end - first);
  if (const size_t bytes = most_bytes * static_cast<size_t>(planes); bytes > scratch_size_) {
    scratch_.reset();  // never two at once
    scratch_ = alignedForOverwrite<std::byte>(bytes);
    scratch_size_ = bytes;
  }
  Stopwatch watch;
  // The same slab of all regions, since their source may decode its planes for them together.
  for (int64_t z = first; z < end; z += planes)
    for (const auto& [box, out] : regions) {
      const Box3 slab{{box.lo.x, box.lo.y, std::max(box.lo.z, z)},
                      {box.hi.x, box.hi.y, std::min(box.hi.z, z + planes)}};
      if (slab.empty()) continue;
      const size_t device_bytes = out.size() / static_cast<size_t>(box.count());
      const auto count = static_cast<size_t>(slab.count());
      const auto before = static_cast<size_t>((slab.lo.z - box.lo.z) * box.size().x * box.size().y);
      const std::span stored(scratch_.get(), count * bytesPerVoxel(type));
      source_.readRegion(time, slab, stored);
      read_ns_ += lapNs(watch);
      toDevice(type, stored, out.subspan(before * device_bytes, count * device_bytes));
      convert_ns_ += lapNs(watch);
    }
}

}  // namespace sluice
