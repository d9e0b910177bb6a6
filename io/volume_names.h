// Names of volumes, for dialogs that offer files to choose from. A pure function.
#pragma once

#include <string>
#include <vector>

namespace sluice {

// The endings of names that openVolume() accepts for volumes, in lower case, each once: ".nrrd",
// ".nii.gz". For a header with a separate file of voxels, the header's; ".zarr" is a folder.
std::vector<std::string> volumeEndings();

}  // namespace sluice
