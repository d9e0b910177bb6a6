// Light that a stretch of a ray takes if its values change linearly, for the reference renderer.
#pragma once

#include <array>

#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// The mean over the values between two, of the extinction (see ReferenceScene::integrates) times
// red, green, blue and 1. By Gauss' rule of three places, in short pieces between the points of the
// transfer function.
std::array<double, 4> meanExtinction(const TransferFunction& transfer, double from, double to);

}  // namespace sluice
