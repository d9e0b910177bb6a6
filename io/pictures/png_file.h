// Pictures as PNG files, 8 bits a channel with straight alpha.
//
// The file is written under a temporary name and renamed when whole. Plain functions, any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/base/values/picture.h"

namespace sluice {

// Throws Error when the file cannot be written, and Interrupted; an older file of that name is then
// as it was.
void writePng(const std::filesystem::path& path, const Rgba8Picture& picture,
              const StopToken& stop = {});
// Writes toRgba8(picture).
void writePng(const std::filesystem::path& path, const Picture& picture,
              const StopToken& stop = {});

// A file that is written a few rows at a time, from the top row down. It has the same bytes as if
// the whole picture were written at once. Without commit() nothing is left of it. One thread.
class PngFile {
 public:
  // The picture's size. Throws as writePng() does, and so do the other functions.
  PngFile(const std::filesystem::path& path, int width, int height, const StopToken& stop = {});
  ~PngFile();
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  // Requires: the picture's width, and no more rows than are left.
  void add(const Rgba8Picture& rows);
  // Requires: all rows were added.
  void commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The bytes of such a file.
std::vector<std::byte> encodedPng(const Rgba8Picture& picture);

// Reads any PNG, whatever its depth and kind, as 8 bit RGBA. Throws Error: no PNG, damaged, or of
// more than 2^28 pixels.
Rgba8Picture readPng(const std::filesystem::path& path);

}  // namespace sluice
