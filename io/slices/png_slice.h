// PNG files as slices, through libpng: grey of 1 to 16 bits, with or without alpha, palettes and
// RGB.
//
// Grey of fewer than 8 bits is spread over 0 to 255, as PNG defines it. Gamma and color profiles
// are left alone: the stored numbers are the values. libpng's messages become Errors, its warnings
// are dropped; nothing reaches standard error.
#pragma once

#include <filesystem>
#include <memory>

#include "io/slices/slice_picture.h"

namespace sluice {

// Throws Error: no PNG, damaged header, more than PictureFormat::kMaxSide pixels a side. An
// interlaced picture, which must be decoded as a whole, may have up to 256 MiB of pixels.
std::unique_ptr<SlicePicture> openPng(const std::filesystem::path& path);

}  // namespace sluice
