// TIFF files as slices, through libtiff: stripped or tiled, any compression that libtiff was built
// with, BigTIFF, several pages (thumbnails and pyramid levels are passed over).
//
// Supported: grey of 8, 16 or 32 bit integers, 32 or 64 bit floats, white-is-zero (inverted to
// black-is-zero if unsigned), palettes and RGB of 8 or 16 bit with the samples of a pixel side by
// side. A flipped orientation is undone; a transposed one is an Error. libtiff's messages become
// Errors, its warnings are dropped; nothing reaches standard error.
#pragma once

#include <filesystem>
#include <memory>

#include "io/slices/slice_picture.h"

namespace sluice {

// As openSlicePicture(). Throws Error: no TIFF, damaged, of another kind than the above, pages that
// differ.
std::unique_ptr<SlicePicture> openTiff(const std::filesystem::path& path,
                                       const std::shared_ptr<const PictureTables>& known);

}  // namespace sluice
