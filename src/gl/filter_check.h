// How exactly the driver interpolates texels: GPUs with eight bits of a texel's side, which shows
// where opacities rise steeply; software as exactly as floats are.
#pragma once

#include "src/gl/contexts/gl_functions.h"

namespace sluice {

// Whether values between two texels of a volume are off by less than a 10 000th of their
// difference. Draws a row of samples and reads it. Requires: the context is current. Throws Error
// if the driver cannot draw it.
bool filtersExactly(const GlFunctions& gl);

}  // namespace sluice
