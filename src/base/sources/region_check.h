// The preconditions of VolumeSource::readRegion().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/error.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

inline void checkRegion(const VolumeLayout& layout, int64_t time, const Box3& box,
                        std::span<const std::byte> out) {
  SLUICE_CHECK(time >= 0 && time < layout.time_steps);
  SLUICE_CHECK(!box.empty() && boxOf(layout.dims).contains(box));
  SLUICE_CHECK_EQ(out.size(), static_cast<size_t>(box.count()) * bytesPerVoxel(layout.type));
}

}  // namespace sluice
