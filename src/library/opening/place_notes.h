// The places of two volumes that are drawn together, and what a user should know of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// One line each, `name` being that of the volume over the first one: their boxes do not meet in the
// world; one of them names no unit of length that the other's lengths could be compared with; a
// place that a file tells is not used. Empty if the second volume has a place in the first one's
// world.
std::vector<std::string> placeNotes(const VolumeLayout& over, const VolumeLayout& first,
                                    const std::string& name);

// The volume over the first one, at the first one's place if only one of the two tells a place, as
// labels that were drawn on a picture often do not. Then there is a line more in `notes`. Only for
// slices and microscopy, whose axes mean the same.
std::unique_ptr<VolumeSource> withPlaceOf(const VolumeLayout& first,
                                          std::unique_ptr<VolumeSource> over,
                                          const std::string& name, std::vector<std::string>& notes);

}  // namespace sluice
