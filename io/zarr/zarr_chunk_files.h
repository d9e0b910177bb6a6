// ZarrChunkFiles: the files of one array, a chunk each or a shard of many: which there are, and
// their bytes.
//
// The existing files are found once, from the checksums if sluice kept some, else from the folder's
// listing at the first question; the chunks of a shard from its index, when it is first needed.
// Later changes on disk are an Error, not a mixture of old and new voxels. Files are opened for
// each read. Any thread may call anything at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/zarr/zarr_array.h"
#include "io/zarr/zarr_checksums.h"
#include "io/zarr/zarr_shard_indices.h"

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

  // The numbers of the files that there are, ascending. Throws Error when the folder cannot be
  // listed.
  const std::vector<int64_t>& existing();
  // Whether a chunk is stored. Throws Error if the checksums deny the chunk, and there is one; the
  // index of its shard cannot be read.
  bool exists(int64_t chunk);
  // The same from the folder alone, whatever the checksums tell.
  std::vector<int64_t> onDisk() const;
  // A checksum over the status of at most `most` files, evenly spread over the numbers; a missing
  // file counts too. It changes when one of them is rewritten, replaced, removed or added.
  uint64_t statusChecksum(int64_t most) const;

  // Reads the bytes of an existing chunk into the memory that `room(bytes)` returns, after their
  // number was found credible, and checks the checksum if there is one. Returns how many there are
  // without a checksum that follows them. Throws Error naming the file.
  uint64_t read(int64_t chunk, const std::function<std::span<std::byte>(uint64_t bytes)>& room);
  // The file of a chunk.
  std::string path(int64_t chunk) const;

  // The memory for indices of shards: null without shards.
  ZarrShardIndices* shardIndices() { return indices_.get(); }

  // Bytes of chunks, indices and checksums.
  uint64_t storedBytesRead() const { return read_bytes_; }

 private:
  void list();
  // Throws Error, naming the file: it is gone, no regular file, or was written after the volume was
  // opened.
  struct OpenFile;
  OpenFile openFile(int64_t file) const;
  // Fills `out` from there. Throws Error, naming the file: it ends before.
  void readAll(const OpenFile& file, uint64_t offset, std::span<std::byte> out);
  void readIndex(int64_t file, std::span<std::byte> index);
  // The bytes of a chunk in its file. Throws Error: it has none, or they are not of this file.
  ZarrChunkPlace placeIn(const OpenFile& file, int64_t chunk);
  void listFolder(const std::filesystem::path& folder, std::vector<int64_t>& index,
                  std::vector<int64_t>& found) const;

  const std::filesystem::path folder_;
  const ZarrArray array_;
  timespec opened_at_ = {};                            // constant after construction
  std::optional<std::vector<StoredChunk>> checksums_;  // constant after construction
  std::once_flag listed_;
  std::vector<int64_t> existing_;              // constant once listed_
  std::unique_ptr<ZarrShardIndices> indices_;  // of shards
  std::atomic<uint64_t> read_bytes_{0};
};

}  // namespace sluice
