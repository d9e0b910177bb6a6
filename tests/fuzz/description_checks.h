// What must hold of every header that a parser lets through, and of every line that it throws.
#pragma once

#include <functional>

#include "io/headers/volume_description.h"

namespace sluice {

// Calls `parse`. Aborts when it throws anything but an Error of one printable line, or when what it
// returns is not fit to be opened.
void checkParser(const std::function<VolumeDescription()>& parse);

}  // namespace sluice
