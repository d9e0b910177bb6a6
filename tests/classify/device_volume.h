// DeviceVolume: a whole small volume as device voxels, so that a test can ask for any of them.
#pragma once

#include <limits>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/classify/boxes/brick_grid.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

struct DeviceVolume {
  explicit DeviceVolume(VolumeSource& source, int64_t time = 0)
      : dims(source.layout().dims), map(deviceMap(source.layout())) {
    const Box3 all = boxOf(dims);
    const VoxelType type = source.layout().type;
    std::vector<std::byte> stored(static_cast<size_t>(all.count()) * bytesPerVoxel(type));
    std::vector<std::byte> device(static_cast<size_t>(all.count()) * bytesPerVoxel(map.type));
    source.readRegion(time, all, stored);
    toDevice(type, stored, device);
    bytes = std::move(device);
    visitDeviceType(map.type, [&](auto tag) {
      const auto* voxel = reinterpret_cast<const decltype(tag)*>(bytes.data());
      values.assign(voxel, voxel + all.count());
    });
    range = {std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
    for (const float value : values) {
      if (value <= kNotANumber || value >= kLargest) continue;
      range = {std::min<double>(range.lo, value), std::max<double>(range.hi, value)};
    }
  }

  // The voxel, or the nearest one that exists.
  float at(Vec3i p) const {
    p = max(min(p, dims - Vec3i{1, 1, 1}), Vec3i{0, 0, 0});
    return values[static_cast<size_t>((p.z * dims.y + p.y) * dims.x + p.x)];
  }
  Box3 cells() const { return boxOf(dims - Vec3i{1, 1, 1}); }
  VoxelSpan span() const { return {boxOf(dims), map.type, bytes.data()}; }

  Vec3i dims;
  ValueMap map;
  std::vector<std::byte> bytes;
  std::vector<float> values;
  ValueRange range;  // range without NaN
};

}  // namespace sluice
