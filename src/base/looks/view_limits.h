// The cameras that can be: beyond these limits a place in the picture is no number any more.
#pragma once

namespace sluice {

inline constexpr double kLeastZoom = 1e-6, kMostZoom = 1e6;
inline constexpr double kLeastFieldOfViewDeg = 1e-3;

}  // namespace sluice
