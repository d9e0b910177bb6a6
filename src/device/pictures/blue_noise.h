// A mask of offsets for the rays of a picture, blue noise: neighbours differ, so that the eye sees
// fine grain in place of rings, and no clouds. The same on every machine. Pure functions.
#pragma once

#include <vector>

namespace sluice {

// The mask repeats after so many pixels along both axes, a power of two.
inline constexpr int kBlueNoiseSide = 64;

// kBlueNoiseSide rows of as many numbers, evenly spread over [-1/2, 1/2). Computed once.
const std::vector<float>& blueNoise();

}  // namespace sluice
