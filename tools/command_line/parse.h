// Parses words of the command line: sizes, triples, colours. Pure functions; each returns nullopt
// or throws Error for a malformed word, as its comment says.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/base/values/vec.h"
#include "src/render/camera/camera.h"

namespace sluice {

// "256,256,128" (also with x between): exactly `count` numbers; nullopt otherwise.
std::optional<std::vector<double>> parseNumbers(const std::string& text, size_t count);
// "512x512" or "512".
std::optional<PictureSize> parsePictureSize(const std::string& text);
// "RRGGBB" with an optional '#': 0..1 a channel.
std::optional<std::array<float, 3>> parseColor(const std::string& text);

// Requires: three numbers, whole ones for asVec3i().
Vec3d asVec3d(const std::vector<double>& numbers);
Vec3i asVec3i(const std::vector<double>& numbers);

}  // namespace sluice
