#include "io/volume_names.h"

namespace sluice {

std::vector<std::string> volumeEndings() {
  return {".nrrd", ".nhdr", ".mhd", ".mha",  ".nii", ".nii.gz", ".hdr", ".hdr.gz",
          ".vdb",  ".png",  ".tif", ".tiff", ".raw", ".raw.gz", ".zarr"};
}

}  // namespace sluice
