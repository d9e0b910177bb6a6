// Pictures as OpenEXR files: premultiplied RGBA, a depth channel Z, further channels, and in the
// header texts and matrices from which the picture can be made again and put into a scene.
//
// Values are written as they are; OpenEXR's readers take colours for linear light (toLinearLight)
// with the primaries of Rec. 709, which sRGB has and the header names. Pixels are square, and data
// and display window are the picture. The file is written under a temporary name and renamed when
// whole. Plain functions, any thread.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/base/values/picture.h"

namespace sluice {

// The type of R, G, B and A; Z always has 32 bits.
enum class ExrPrecision { kHalf, kFloat };

// Name and text, each a string attribute of the header. A name is 1 to 255 characters; those that
// OpenEXR uses itself ("channels", "compression", ...) are refused.
using ExrAttributes = std::vector<std::pair<std::string, std::string>>;
// Name and matrix, row after row, for row vectors from the left: an M44f attribute.
using ExrMatrices = std::vector<std::pair<std::string, std::array<float, 16>>>;

// A channel with one 32-bit value a pixel.
struct ExrChannel {
  std::string name;  // neither R, G, B, A nor Z
  std::vector<float> values;
};

struct ExrContents {
  Picture picture;  // read: missing color channels are 0, a missing alpha is 1
  ExrAttributes attributes = {};
  ExrMatrices matrices = {};
  std::vector<ExrChannel> channels = {};  // in addition to the picture's, by name
  // Width of a perspective picture at distance 1 from the eye; else OpenEXR's default, 1.
  float screen_window_width = 1;
};

// Zip-compressed scan lines. Z is written when the picture has depths. Throws Error when the file
// cannot be written or a name is not allowed, and Interrupted; an older file is then as it was.
void writeExr(const std::filesystem::path& path, const ExrContents& contents,
              ExrPrecision precision = ExrPrecision::kHalf, const StopToken& stop = {});

// A file that is written a few rows at a time, from the top row down. It has the same bytes as if
// the whole picture were written at once. Without commit() nothing is left of it. One thread.
class ExrFile {
 public:
  // `first` are the first rows: their header is the file's, and all rows have their channels. They
  // are not written yet; pass them to add(). `height` is the whole picture's. Throws as writeExr()
  // does, and so do the other functions.
  ExrFile(const std::filesystem::path& path, const ExrContents& first, int height,
          ExrPrecision precision = ExrPrecision::kHalf, const StopToken& stop = {});
  ~ExrFile();
  ExrFile(const ExrFile&) = delete;
  ExrFile& operator=(const ExrFile&) = delete;

  // Ignores the rows' attributes. Requires: the first rows' width and channels, and no more rows
  // than are left.
  void add(const ExrContents& rows);
  // Requires: all rows were added.
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Reads the first part of a flat EXR. Throws Error: no EXR, damaged, or of more than 2^28 pixels.
ExrContents readExr(const std::filesystem::path& path);

}  // namespace sluice
