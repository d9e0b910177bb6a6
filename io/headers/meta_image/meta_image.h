// MetaImage volumes: .mhd with the voxels in other files, .mha with them inside.
// meta_image_header.h lists the supported keys.
#pragma once

#include <filesystem>
#include <memory>

#include "io/headers/decode_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Throws Error when a file is missing, malformed or too small.
std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& path,
                                            const DecodeOptions& decode = {});

}  // namespace sluice
