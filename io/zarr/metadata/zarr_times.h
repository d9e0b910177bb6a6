// The times of the steps of a Zarr image.
#pragma once

#include <string>

#include "io/zarr/metadata/zarr_image.h"

namespace sluice {

// Sets the view's times, as far as the axis of time tells them, and notes of numbers that are no
// times, which start with `path`. Requires: the view has its axes and its number of steps.
void placeSteps(const ZarrImage& image, const std::string& path, ZarrView& view);

}  // namespace sluice
