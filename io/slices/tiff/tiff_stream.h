// TiffStream: the state of libtiff's callbacks: positions and bytes of our file, and the first
// failure, which libtiff would print. One thread.
#pragma once

#include <tiffio.h>

#include <array>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "io/files/file.h"

namespace sluice {

// The first failure that libtiff told; without a message: none.
struct TiffFailure {
  std::string message;
  bool is_of_reading = false;  // the file could not be read, whatever it holds
};

struct TiffStream {
  explicit TiffStream(const std::filesystem::path& path) : file(path) {}

  // Throws Error: the last failure, if any, after `what`.
  [[noreturn]] void failWith(const std::string& what);

  File file;
  uint64_t position = 0;
  // Small pieces, as in tables, come out of a window: libtiff asks for a few bytes at a time.
  std::array<std::byte, 2048> window;
  uint64_t window_at = 0;
  size_t window_size = 0;
  TiffFailure failure;
  // libtiff has put the pixels' own size in place of what a table says of its only strip, because
  // that is too little or nothing.
  bool strip_size_replaced = false;
};

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffPtr = std::unique_ptr<TIFF, CloseTiff>;

// Opens for reading, never mapped; `stream` must outlive it. Throws Error if it is no TIFF.
TiffPtr openTiff(TiffStream& stream);

}  // namespace sluice
