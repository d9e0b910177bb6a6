// ZarrChunkFiles: the chunk files of one array: which there are, and their bytes.
//
// Which there are is found once, from the checksums where sluice kept some, else from the folder's
// listing at the first question; what changes on disk afterwards is an Error, not a mixture of old
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
  // What the checksums say of a chunk. Requires: hasChecksums().
  const StoredChunk& stored(int64_t chunk) const;

  // The numbers of the chunks that have a file, ascending. Throws Error when the folder cannot be
  // listed.
  const std::vector<int64_t>& existing();
  // Throws Error where the checksums say that there is none, and there is one.
  bool exists(int64_t chunk);
  // The same from the folder alone, whatever the checksums say.
  std::vector<int64_t> onDisk() const;
  // Of the status of at most `most` chunk files, evenly spread over the numbers; a missing file
  // counts too. Changes when one of them is rewritten, replaced, removed or added.
  uint64_t statusChecksum(int64_t most) const;

  // Reads the whole file of an existing chunk into what `room(bytes)` returns, after its size was
  // found credible; checks the checksum where there is one. Throws Error naming the file.
  void read(int64_t chunk, const std::function<std::span<std::byte>(uint64_t bytes)>& room);
  std::string path(int64_t chunk) const;

  // Of chunks and checksums.
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
