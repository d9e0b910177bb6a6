// Pictures as OpenEXR files: premultiplied RGBA, a depth channel Z, and texts in the header from
// which the picture can be made again (camera, transfer function, version).
//
// Written under a temporary name and renamed when whole. Plain functions, any thread.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/picture.h"

namespace sluice {

// Of R, G, B and A; Z is always 32 bit.
enum class ExrPrecision { kHalf, kFloat };

// Name and text, each a string attribute of the header. A name is 1 to 255 characters; those that
// OpenEXR uses itself ("channels", "compression", ...) are refused.
using ExrAttributes = std::vector<std::pair<std::string, std::string>>;

// Zip-compressed scan lines. Z is written when the picture has depths. Throws Error when the file
// cannot be written or an attribute's name is not allowed; an older file is then as it was.
void writeExr(const std::filesystem::path& path, const Picture& picture,
              const ExrAttributes& attributes = {}, ExrPrecision precision = ExrPrecision::kHalf);

struct ExrContents {
  Picture picture;           // missing color channels are 0, a missing alpha is 1
  ExrAttributes attributes;  // the string attributes, by name
};

// Reads the first part of a flat EXR. Throws Error: no EXR, damaged, or of more than 2^28 pixels.
ExrContents readExr(const std::filesystem::path& path);

}  // namespace sluice
