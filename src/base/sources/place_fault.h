// Tells whether a volume lies at its place. Pure functions of a layout.
#pragma once

#include "src/base/sources/volume_source.h"

namespace sluice {

// Whether the volume lies at the origin only because its place is not known.
inline bool isUnplaced(const VolumeLayout& layout) {
  return (!layout.tells_place || !layout.place_fault.empty()) && layout.origin == Vec3d{};
}

}  // namespace sluice
