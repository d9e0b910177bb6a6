// NRRD volumes: attached (.nrrd), detached (.nhdr), in several files. nrrd_header.h lists the
// supported fields.
#pragma once

#include <filesystem>
#include <memory>

#include "io/headers/decode_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Throws Error when a file is missing, malformed or too small.
std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& path,
                                       const DecodeOptions& decode = {});

}  // namespace sluice
