// Pictures as OpenEXR files: premultiplied RGBA, a depth channel Z, further channels, and in the
// header texts and matrices from which the picture can be made again and put into a scene.
//
// Values are written as they are; OpenEXR's readers take colours for linear light (toLinearLight)
// with the primaries of Rec. 709, which sRGB has and the header says. Pixels are square, and data
// and display window are the picture. Written under a temporary name and renamed when whole. Plain
// functions, any thread.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "src/base/picture.h"
#include "src/base/stop_token.h"

namespace sluice {

// Of R, G, B and A; Z is always 32 bit.
enum class ExrPrecision { kHalf, kFloat };

// Name and text, each a string attribute of the header. A name is 1 to 255 characters; those that
// OpenEXR uses itself ("channels", "compression", ...) are refused.
using ExrAttributes = std::vector<std::pair<std::string, std::string>>;
// Name and matrix, row after row, for row vectors from the left: an M44f attribute.
using ExrMatrices = std::vector<std::pair<std::string, std::array<float, 16>>>;

// One value a pixel, 32 bit.
struct ExrChannel {
  std::string name;  // neither R, G, B, A nor Z
  std::vector<float> values;
};

struct ExrContents {
  Picture picture;  // read: missing color channels are 0, a missing alpha is 1
  ExrAttributes attributes = {};
  ExrMatrices matrices = {};
  std::vector<ExrChannel> channels = {};  // besides the picture's, by name
  // Of a perspective picture at distance 1 from the eye; OpenEXR's 1 where there is none.
  float screen_window_width = 1;
};

// Zip-compressed scan lines. Z is written when the picture has depths. Throws Error when the file
// cannot be written or a name is not allowed, and Interrupted; an older file is then as it was.
void writeExr(const std::filesystem::path& path, const ExrContents& contents,
              ExrPrecision precision = ExrPrecision::kHalf, const StopToken& stop = {});

// Reads the first part of a flat EXR. Throws Error: no EXR, damaged, or of more than 2^28 pixels.
ExrContents readExr(const std::filesystem::path& path);

}  // namespace sluice
