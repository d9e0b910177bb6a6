// The contents of a folder in a Zarr store, by its metadata files: .zarray and .zattrs of version
// 2, zarr.json of version 3.
//
// A folder is an array, or an image, whose first level is the volume. An array that is a level of
// the image around it has its scale from there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/zarr/zarr_image.h"

namespace sluice {

// A metadata file.
struct ZarrHeader {
  std::string path, text, identity;
};

// The array in a folder, and its description.
struct FoundZarr {
  std::filesystem::path array_folder;
  ZarrImage image;
  std::vector<std::string> identities, header_paths;  // of the metadata files that were read
  uint64_t header_bytes = 0;
  std::string said_by;    // the file that names the axes, or else the array's own
  bool is_image = false;  // the folder is an image's, the array its level 0

  void take(const ZarrHeader& header);
};

// Whether a folder is a Zarr group or array, of any version.
bool isZarr(const std::filesystem::path& folder);

// Throws Error: neither an array nor an image, metadata that cannot be read.
FoundZarr findZarr(const std::filesystem::path& folder);

// An array in the place of dataset `number` of the image.
FoundZarr datasetOf(const FoundZarr& image, const std::filesystem::path& array_folder,
                    size_t number);

// The .zarray or zarr.json of an array. Throws Error: there is none.
ZarrHeader readArrayHeader(const std::filesystem::path& array_folder);

}  // namespace sluice
