// Frames that a bench draws before the first that it measures.
#pragma once

namespace sluice {

inline constexpr int kWarmFrames = 2;

}  // namespace sluice
