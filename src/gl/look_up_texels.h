// What a frame's look-up becomes as texels, and what modes other than composite make of the numbers
// that they bring back. Pure functions.
#pragma once

#include <vector>

#include "src/render/device.h"

namespace sluice {

// rgba of the look-up texture. Parallel views have one distance between samples, so the opacity is
// corrected and the colour premultiplied here; perspective ones get log2(1 - opacity) for a unit of
// slice_length and do the rest a pixel. Other modes get as alpha the part, 0 to 1, that a sample of
// the entry takes.
std::vector<float> lookUpTexels(const FrameSetup& setup);

// In place: from the numbers of modes other than composite (see MODE in the shader) to their
// colours, premultiplied.
void resolveMode(const FrameSetup& setup, std::vector<float>& rgba);

}  // namespace sluice
