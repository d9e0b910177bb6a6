// Copies volumes of web servers to this machine: a file as it is, or a Zarr or N5 store with all
// that its metadata name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "io/open_options.h"
#include "io/stores/download.h"

namespace sluice {

struct FetchOptions {
  OpenOptions open = {};         // how servers are asked
  ExpectedObject expected = {};  // of a file
  DownloadOptions download = {};
};

struct FetchedVolume {
  bool is_store = false;
  int64_t files = 1,
          missing_files = 0;  // of a store; chunks that are not there have the fill value
  Downloaded object = {};     // of a store the sum, without a checksum
};

// Copies what lies at an address to `target`, a file or, for a store, a folder, which appears whole
// or not at all (download.h). Of a store that was begun, files that are there stay as they are,
// unless it was begun from another address or its metadata have changed since.
// `progress`: bytes of a file, files of a store. Throws Error, Interrupted.
FetchedVolume fetchVolume(const std::string& address, const std::filesystem::path& target,
                          const FetchOptions& options, ProgressMeter& progress);

}  // namespace sluice
