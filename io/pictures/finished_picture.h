// Whether a PNG or EXR file is whole: a power cut, a full disk or a copy may leave a part of one.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

namespace sluice {

// The width and height of the picture in a file, of which all parts are there; nullopt: no such
// file, an empty or cut one, or one of another kind. Reads only the header and the end, so that
// pixels may still be damaged. Throws Error if the file cannot be read. Any thread.
std::optional<std::array<int64_t, 2>> sizeOfWholePicture(const std::filesystem::path& path);

}  // namespace sluice
