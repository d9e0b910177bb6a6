// Turns a parsed header into a volume that can be read: finds the data files, checks their sizes.
//
// The one way in for every format of the "header, then voxels" family.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "io/files/file.h"
#include "io/headers/decode_options.h"
#include "io/headers/volume_description.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// The front of a text header's file: as much as `complete` wants to see, at most 16 MiB (a file
// that is none of these formats is not read to its end).
std::string readHead(File& file, const std::function<bool(std::string_view)>& complete);

// Opens the data files (relative to the header's folder; the header's own file if there are none).
// Throws Error when one is missing or too small, with the arithmetic of its size; one that is
// larger than needed is fine, as the header decides. Encoded data are decoded at the first read,
// into a DecodedFile. `selection` is added to the identity: the user's choices beyond the files.
std::unique_ptr<VolumeSource> openDescribed(std::shared_ptr<File> header,
                                            const VolumeDescription& description,
                                            const std::string& selection = "",
                                            const DecodeOptions& decode = {});

}  // namespace sluice
