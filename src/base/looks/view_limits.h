// The limits of a view. Beyond those of the camera a place in the picture is no number any more.
#pragma once

#include <cstddef>

namespace sluice {

inline constexpr double kLeastZoom = 1e-6, kMostZoom = 1e6;
inline constexpr double kLeastFieldOfViewDeg = 1e-3;
// Clip planes of a view. A device takes more (frame_values.h), for the sides of the clip box.
inline constexpr size_t kMostAskedPlanes = 6;

}  // namespace sluice
