// ZarrChunkFiles: the chunk files of one array: which there are, and their bytes.
//
// The existing chunks are found once, from the checksums if sluice kept some, else from the
// folder's listing at the first question; later changes on disk are an Error, not a mixture of old
// and new voxels. Files are opened for each read. Any thread may call anything at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/zarr/zarr_array.h"
#include "io/zarr/zarr_checksums.h"

namespace sluice {

class ZarrChunkFiles {
 public:
  // `array_text`: the .zarray that `array` was parsed from. Throws Error: checksums that are
  // damaged.
  ZarrChunkFiles(std::filesystem::path folder, ZarrArray array, std::string_view array_text);

  const ZarrArray& array() const { return array_; }
  bool hasChecksums() const { return checksums_.has_value(); }
  // The checksum record of a chunk. Requires: hasChecksums().
  const StoredChunk& stored(int64_t chunk) const;

  // The numbers of the chunks that have a file, ascending. Throws Error when the folder cannot be
  // listed.
  const std::vector<int64_t>& existing();
  // Throws Error if the checksums deny the chunk, and there is one.
  bool exists(int64_t chunk);
  // The same from the folder alone, whatever the checksums tell.
  std::vector<int64_t> onDisk() const;
  // A checksum over the status of at most `most` chunk files, evenly spread over the numbers; a
  // missing file counts too. It changes when one of them is rewritten, replaced, removed or added.
  uint64_t statusChecksum(int64_t most) const;

  // Reads the whole file of an existing chunk into the memory that `room(bytes)` returns, after its
  // size was found credible; checks the checksum if there is one. Throws Error naming the file.
  void read(int64_t chunk, const std::function<std::span<std::byte>(uint64_t bytes)>& room);
  std::string path(int64_t chunk) const;

  // Bytes of chunks and checksums.
  uint64_t storedBytesRead() const { return read_bytes_; }

 private:
  void list();
  void listFolder(const std::filesystem::path& folder, std::vector<int64_t>& index,
                  std::vector<int64_t>& found) const;

  const std::filesystem::path folder_;
  const ZarrArray array_;
  timespec opened_at_ = {};                            // constant after construction
  std::optional<std::vector<StoredChunk>> checksums_;  // constant after construction
  std::once_flag listed_;
  std::vector<int64_t> existing_;  // constant once listed_
  std::atomic<uint64_t> read_bytes_{0};
};

}  // namespace sluice
