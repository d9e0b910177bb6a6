// The device under test: one suite tests every device, its sources linked once with each definition
// of this function.
#pragma once

#include <memory>

#include "src/device/device.h"

namespace sluice {

// A device whose pictures are the same on every machine. Throws Error if the machine cannot have
// it.
std::unique_ptr<Device> suiteDevice();

}  // namespace sluice
