// Names of volumes, for who offers files to choose from. A pure function.
#pragma once

#include <string>
#include <vector>

namespace sluice {

// How names end that openVolume() takes for volumes, in lower case, each once: ".nrrd", ".nii.gz".
// Of headers with a file of voxels beside them the header's; ".zarr" is a folder.
std::vector<std::string> volumeEndings();

}  // namespace sluice
