// TiffTables: what the tables of a TIFF say of its pages, from one walk through all of them.
#pragma once

#include <tiffio.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/slices/slice_picture.h"
#include "io/slices/tiff/tiff_page.h"
#include "io/slices/tiff/tiff_stream.h"

namespace sluice {

struct TiffTables final : PictureTables {
  std::vector<TiffPage> pages;
  // Places of the tables of each page's reduced images, the largest first.
  std::vector<std::vector<uint64_t>> reduced;
  struct stat file_status = {};  // of the file that was read
};

// Requires: libtiff stands at the first table. Throws Error: damaged, of a kind that is not
// supported, or pages that differ.
std::shared_ptr<const TiffTables> readTiffTables(TIFF* tiff, TiffStream& stream);

// The page at whose table libtiff stands, by itself: its size, its type and its pieces. Throws
// Error, which names the file at `path`.
PictureFormat tiffFormatOf(TIFF* tiff, const TiffPage& p, const std::string& path);

}  // namespace sluice
