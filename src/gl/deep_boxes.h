// Boxes whose rays would take too many turns of the shaders' loops. Mesa's llvmpipe ends all loops
// of a pixel after 65535 turns, and the samples behind would be missing without a word.
//
// Pure functions.
#pragma once

#include <span>
#include <vector>

#include "src/device/frame_values.h"
#include "src/gl/shaders/shaders.h"

namespace sluice {

// Slices of a box that a ray can sample in one go, at least 1.
double mostSlices(const ShaderVariant& variant, size_t channels);

// The same boxes, those with more slices along a ray in parts that follow one another from front to
// back. Boxes that join others are cut together with them.
std::vector<BoxDraw> cutDeepBoxes(const FrameSetup& setup, std::span<const BoxDraw> boxes,
                                  double most_slices);

}  // namespace sluice
