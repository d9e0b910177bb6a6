// The header of a MetaImage file (.mhd with separate data, .mha with data inside).
//
// Supported keys: NDims (2 to 4, the fourth is time), DimSize, ElementType, ElementNumberOfChannels
// (must be 1), ElementByteOrderMSB or BinaryDataByteOrderMSB (little-endian when neither is there),
// BinaryData, CompressedData, CompressedDataSize, HeaderSize (-1: the data are the last bytes),
// ElementSpacing (or else ElementSize), Offset (or Position, Origin), TransformMatrix (or
// Orientation, Rotation; the direction of the first axis first), ElementMin and ElementMax,
// ElementToIntensityFunctionSlope and -Offset, ElementDataFile (LOCAL, a name, LIST with the number
// of dimensions a file holds, a pattern with first, last and step), AnatomicalOrientation (letters,
// or a matrix without it: the world is ITK's, WorldFrame::kLps; "???" or neither: none is known),
// DistanceUnits. Other keys are ignored. MET_LONG and MET_ULONG have 32 bits here, as in the
// library that the format comes from.
#pragma once

#include <string>
#include <string_view>

#include "io/headers/volume_description.h"

namespace sluice {

// Whether the first bytes of a file hold all of the header: up to the line of ElementDataFile. A
// header with a LIST goes on to the end of the file.
bool metaImageHeaderComplete(std::string_view text);

// Pure. `text` holds the header (bytes after it are not looked at), `path` names it in messages.
// Throws Error for anything malformed.
VolumeDescription parseMetaImageHeader(std::string_view text, const std::string& path);

}  // namespace sluice
