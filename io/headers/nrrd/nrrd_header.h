// The header of a NRRD file (teem's "nearly raw raster data", formats NRRD0001 to NRRD0005).
//
// Supported fields: type, dimension, sizes, encoding (raw, gzip, text), endian, line skip, byte
// skip, spacings, space, space directions, space origin, space units, units, kinds, min and max (as
// the stored range), data file (one, LIST, pattern; with the number of dimensions a file holds).
// Comments, key/values and all other fields are ignored; bzip2 and hex encoding, blocks and 64-bit
// integers are an Error.
//
// Three axes are the volume's, fastest first. An axis is not an axis of space if its direction is
// "none", its kind differs from space and domain, or, of four and more axes, its spacing is nan.
// The slowest such axis gives the time steps; of four axes that are all of space the last does. Any
// other axis must have size 1 (colors and vectors are an Error). World positions are as in the
// file. `space` gives them a meaning if it is a patient's (left-anterior-superior, a mirror image,
// is turned into right-anterior-superior), but not if it is a scanner's. `space units` or `units`
// of the first axis are the unit. A negative spacing turns the axis round.
#pragma once

#include <string>
#include <string_view>

#include "io/headers/volume_description.h"

namespace sluice {

// How far the header goes in the first bytes of a file: past the blank line that ends it, or npos
// while there is none (a detached header may end with the file instead).
size_t nrrdHeaderBytes(std::string_view text);

// Pure. `text` is the header (bytes after the blank line are not looked at), `path` names it in
// messages. Throws Error for anything malformed.
VolumeDescription parseNrrdHeader(std::string_view text, const std::string& path);

}  // namespace sluice
