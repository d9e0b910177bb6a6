// Tells whether a volume lies at its place. Pure functions of a layout.
#pragma once

#include "src/base/values/volume_source.h"

namespace sluice {

// VolumeLayout::place_fault of a file that tells no place. It is nothing to be said, unless the
// volume is drawn beside one that has a place.
inline constexpr const char* kTellsNoPlace = "the file tells no place";

// Whether the volume lies at the origin only because its place is not known.
inline bool isUnplaced(const VolumeLayout& layout) {
  return !layout.place_fault.empty() && layout.origin == Vec3d{};
}

}  // namespace sluice
