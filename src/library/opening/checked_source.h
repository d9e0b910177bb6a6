// Opens the source of a volume, and checks that it has what a user asks of it.
#pragma once

#include <memory>

#include "src/base/sources/volume_source.h"
#include "src/library/requests.h"

namespace sluice {

// Opens the volume and checks that it has the time step. A volume of one voxel along an axis is
// made thick enough to be drawn (thick_source.h). Throws Error.
std::unique_ptr<VolumeSource> openSource(const VolumeArguments& arguments);
// The same of a source that is open already.
std::unique_ptr<VolumeSource> checkedSource(std::unique_ptr<VolumeSource> opened,
                                            const VolumeArguments& arguments);

}  // namespace sluice
