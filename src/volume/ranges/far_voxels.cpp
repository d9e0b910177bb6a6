#include "src/volume/ranges/far_voxels.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

namespace sluice {

void widenFar(ValueRange& range, const ValueRange& by) {
  if (by.lo > by.hi) return;
  range =
      range.lo > range.hi ? by : ValueRange{std::min(range.lo, by.lo), std::max(range.hi, by.hi)};
}

bool hasFarVoxels(const float* voxels, Vec3i size, Vec3i stride_size) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const float* row = voxels + (z * stride_size.y + y) * stride_size.x;
      for (int64_t x = 0; x < size.x; ++x)
        if (std::abs(row[x]) == kLargest) return true;
    }
  return false;
}

ValueRange farRange(VolumeSource& source, int64_t time, const Box3& box) {
  const VoxelType type = source.layout().type;
  ValueRange range{1, 0};
  visitVoxelType(type, [&](auto tag) {
    using Stored = decltype(tag);
    if constexpr (std::is_floating_point_v<Stored>) {
      const auto count = static_cast<size_t>(box.count());
      const auto stored = std::make_unique_for_overwrite<Stored[]>(count);
      source.readRegion(time, box, std::as_writable_bytes(std::span(stored.get(), count)));
      for (size_t i = 0; i < count; ++i) {
        const auto value = static_cast<double>(stored[i]);
        if (std::isfinite(value) && std::abs(value) > double{kLargest})
          widenFar(range, {value, value});
      }
    }
  });
  return range;
}

}  // namespace sluice
