// The contents of a folder in a Zarr store, by its metadata files: .zarray and .zattrs of version
// 2, zarr.json of version 3.
//
// A folder is an array, or an image, whose first level is the volume. An array that is a level of
// the image around it has its scale from there.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/stores/chunk_store.h"
#include "io/zarr/metadata/zarr_image.h"

namespace sluice {

// A metadata file.
struct ZarrHeader {
  std::string path, text, identity;  // its name in messages
};

// The array in a folder, and its description.
struct FoundZarr {
  StorePlace array_folder;
  ZarrImage image;
  std::vector<std::string> identities, header_paths;  // of the metadata files that were read
  uint64_t header_bytes = 0;
  std::vector<std::string> notes;  // for people, one line each
  std::string said_by;             // the file that names the axes, or else the array's own
  bool is_image = false;           // the folder is an image's, the array its level 0
  bool is_version3 = false;        // the image's metadata are

  // Counts the file among those that were read.
  void take(const ZarrHeader& header);
};

// The whole name of a piece or folder and its stamp: a line that changes when it does.
std::string identityOf(const StorePlace& place);

// Whether a folder is a Zarr group or array, of any version.
bool isZarr(const StorePlace& folder);

// Throws Error: neither an array nor an image, metadata that cannot be read.
FoundZarr findZarr(const StorePlace& folder);

// A metadata file of a folder; nullopt: there is none. Throws Error: it cannot be read, or is
// larger than any.
std::optional<ZarrHeader> findHeader(const StorePlace& folder, const char* name);

// The file that describes an array: that of the image's version, or else the other one. Throws
// Error: there is none.
ZarrHeader readArrayHeader(const StorePlace& array_folder, bool is_version3);
// Tells the store that readArrayHeader(), and then readZarrChecksums(), will be called for these.
void expectArrays(const std::vector<StorePlace>& array_folders, bool is_version3);

}  // namespace sluice
