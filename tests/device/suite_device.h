// One suite tests every device: its sources are linked once with each definition of this function.
#pragma once

#include <memory>

#include "src/device/device.h"

namespace sluice {

// Whose pictures are the same everywhere. Throws Error where the machine cannot have it.
std::unique_ptr<Device> suiteDevice();

}  // namespace sluice
