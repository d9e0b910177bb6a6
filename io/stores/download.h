// Download: copies an object of a store, such as a web server's, to a file of this machine.
//
// The bytes go to FILE.part, and what is known of the object to FILE.part-of; once all bytes are
// there and the checksum is right, FILE.part becomes FILE. So a download that ends early, killed or
// without a connection, goes on where it stopped, and FILE is whole or not there. An object that
// has changed since, or that comes whole instead of in parts, is begun anew.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "io/stores/chunk_store.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// The facts that are known of an object before it is read.
struct ExpectedObject {
  std::optional<uint64_t> bytes = {};
  std::string sha256 = {};  // 64 digits in lower case; empty: not known
};

struct DownloadOptions {
  int reads = 4;  // parts of the object that are read at once
  uint64_t piece_bytes = uint64_t{8} << 20;
  bool has_checksum = true;  // make the SHA-256 of the object, also if none is expected
  StopToken stop = {};
};

struct Downloaded {
  uint64_t bytes = 0, resumed_bytes = 0;  // of the object; of these, there before
  std::string sha256;                     // empty without DownloadOptions::has_checksum
};

// Returns nullopt if there is no such object. Adds its bytes to `progress`. Throws Error, naming
// the object: it cannot be read, changes while it is read, has another size or checksum than
// expected; or naming the file: it cannot be written. Throws Interrupted. Any other process must
// leave the files alone meanwhile, which a lock sees to: the second one throws Error.
std::optional<Downloaded> download(const StorePlace& object, const std::filesystem::path& file,
                                   const ExpectedObject& expected, const DownloadOptions& options,
                                   ProgressMeter& progress);

}  // namespace sluice
