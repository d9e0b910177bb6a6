// NIfTI volumes: .nii, a pair of .hdr and .img, each also gzipped (told by its bytes, not its
// name). nifti_header.h lists the supported fields.
#pragma once

#include <filesystem>
#include <memory>

#include "io/headers/decode_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Either file of a pair may be named. Throws Error when a file is missing, malformed or too small.
std::unique_ptr<VolumeSource> openNifti(const std::filesystem::path& path,
                                        const DecodeOptions& decode = {});

}  // namespace sluice
