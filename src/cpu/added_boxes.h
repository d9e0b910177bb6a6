// The boxes of several channels whose pictures are added. Pure function.
#pragma once

#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

// The boxes of all channels in one list, in which each channel's keep their order. Boxes of the
// same cells join, as far as the orders allow: channel c's have the number c.
std::vector<BoxDraw> joinAlike(std::span<const std::vector<BoxDraw>> of_channels);

}  // namespace sluice
