// Pictures as PNG files, 8 bits a channel with straight alpha.
//
// Written under a temporary name and renamed when whole. Plain functions, any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "src/base/picture.h"
#include "src/base/stop_token.h"

namespace sluice {

// Throws Error when the file cannot be written, and Interrupted; an older file of that name is then
// as it was.
void writePng(const std::filesystem::path& path, const Rgba8Picture& picture,
              const StopToken& stop = {});
// Of toRgba8(picture).
void writePng(const std::filesystem::path& path, const Picture& picture,
              const StopToken& stop = {});
// The bytes of such a file.
std::vector<std::byte> encodedPng(const Rgba8Picture& picture);

// Reads any PNG, whatever its depth and kind, as 8 bit RGBA. Throws Error: no PNG, damaged, or of
// more than 2^28 pixels.
Rgba8Picture readPng(const std::filesystem::path& path);

}  // namespace sluice
