// Parses OME's XML, which orders the pages of a TIFF file, or of a set of several, as a volume.
//
// Pure: no file is touched. Source: the OME-TIFF specification. The first image's <Pixels> counts,
// with its dimension order, its channels and its <TiffData> blocks, which may name other files. A
// file of a set may name a companion instead (<BinaryOnly>), which has the XML.
#pragma once

#include <cstdint>
#include <string_view>

#include "io/slices/page_order.h"

namespace sluice {

// `pages` tables were found in the file. XML that does not fit, or that is none, gives `pages`
// slices and a note.
PageOrder parseOmeDescription(std::string_view xml, int64_t pages);

}  // namespace sluice
