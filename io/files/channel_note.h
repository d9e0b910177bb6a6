// What a volume of several channels says of the one that is read.
#pragma once

#include <string>
#include <vector>

#include "src/base/volume_source.h"

namespace sluice {

// Adds a note to the layout of a volume of several channels of which the user chose none: which is
// read, what the others are, how to choose. `names` may be fewer than the channels.
void noteChannels(const std::string& path, const std::vector<std::string>& names,
                  VolumeLayout& layout);

}  // namespace sluice
