// Parses the description in a TIFF, which orders its pages as a volume: ImageJ's lines, OME's XML
// (ome_description.h), or the shape of an array as tifffile writes it.
//
// Pure: no file is touched, so that damage can be tried. Sources: ImageJ's TiffDecoder conventions
// ("ImageJ=1.53t", hyperstacks in the order channel, slice, frame); tifffile's
// {"shape": [2, 3, 20, 30], "axes": "TZYX", "truncated": true}, of which only the shape is always
// there.
#pragma once

#include <cstdint>
#include <string_view>

#include "io/slices/page_order.h"

namespace sluice {

// `pages` tables were found in the file. `pixels_a_unit` are its resolution tags, 0 if it has none:
// ImageJ keeps the pixel's size there. A description of neither kind, or one that does not fit the
// pages, gives `pages` slices; the latter with a note.
PageOrder parseTiffDescription(std::string_view description, int64_t pages, double pixels_a_unit_x,
                               double pixels_a_unit_y);

}  // namespace sluice
