// Images of microscopes in HDF5: Imaris (.ims), and BigDataViewer's .h5 with its .xml. Both keep an
// array for each time step, channel and level of resolution.
//
// Imaris gives the extent of the image, and pads its arrays; names of channels come along.
// BigDataViewer's set-ups are the channels. It stores unsigned numbers of 16 bits as if they were
// signed, and they are read so. Its .xml gives the place of the set-up that is read (the transform
// of its first time step), and the unit; without it (an .h5 alone) a voxel is 1 wide.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "io/hdf5/hdf5_input.h"
#include "io/zarr/reading/chunked_source.h"

namespace sluice {

// Null: the file has no such groups. Throws Error.
std::unique_ptr<VolumeSource> openHdf5Image(const Hdf5Input& input, const std::string& path,
                                            const ChunkedOptions& options);

// The image that a BigDataViewer .xml describes, in .h5 or N5. Throws Error.
std::unique_ptr<VolumeSource> openBdvXml(const std::string& path, const ChunkedOptions& options);

}  // namespace sluice
