// Properties of every header that a parser accepts, and of every message that it throws.
#pragma once

#include <functional>

#include "io/headers/volume_description.h"

namespace sluice {

// Calls `parse`. Aborts when it throws anything but an Error of one printable line, or returns a
// description that is not fit to be opened.
void checkParser(const std::function<VolumeDescription()>& parse);

}  // namespace sluice
