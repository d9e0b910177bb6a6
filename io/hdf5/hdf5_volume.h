// A data set of an HDF5 file as a volume: FILE.h5:/path/in/it, or the one volume of a file.
//
// NetCDF-4 files are HDF5. Axes, spacing and missing values are as in hdf5_axes.h; axes without
// names are t c z y x, as in Zarr. Voxels in one piece are read in place; those in chunks as
// ChunkedSource says. Images of Imaris and BigDataViewer are known by their groups, see
// hdf5_images.h.
#pragma once

#include <memory>
#include <string>

#include "io/zarr/reading/chunked_source.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// `set`: the path of a data set; empty: the file's only volume. Throws Error: none or several (with
// their names), one that cannot be read, the module is missing.
std::unique_ptr<VolumeSource> openHdf5(const std::string& path, const std::string& set,
                                       const ChunkedOptions& options);

}  // namespace sluice
