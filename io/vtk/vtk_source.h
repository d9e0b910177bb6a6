// VTK's images as a VolumeSource: .vti (XML ImageData of one piece) and legacy .vtk of structured
// points.
//
// The arrays of one number a point are the channels, the one that the file calls active first; of a
// file without any those of one number a cell. Cells lie between points, so their volume has one
// voxel less along each axis and begins half a voxel later. Bytes that are appended or binary are
// read in place, compressed ones block by block; text is decoded once into a temporary file.
#pragma once

#include <filesystem>
#include <memory>

#include "io/files/channel_choice.h"
#include "io/headers/decode_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Throws Error: no such file, no array that can be read, --channel without such an array.
std::unique_ptr<VolumeSource> openVtk(const std::filesystem::path& path, const ChannelWish& channel,
                                      const DecodeOptions& decode);

}  // namespace sluice
