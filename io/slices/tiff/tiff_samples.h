// Stored pixels of a TIFF as rows of scalars.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/slices/tiff/tiff_page.h"
#include "io/slices/tiff/tiff_stream.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

// The luminance of each entry of the palette of the page at which `tiff` stands. Throws Error.
std::vector<uint8_t> paletteOf(TIFF* tiff, TiffStream& stream);

// Converts a row of p.width pixels, from left to right unless it is mirrored. Requires: a palette
// of 256 entries if the page has one.
void convertPixels(const TiffPage& p, VoxelType type, std::span<const uint8_t> palette,
                   const std::byte* stored, std::span<std::byte> out, bool is_mirrored);

}  // namespace sluice
