// ZarrChunkFiles: the files of one array, a chunk each or a shard of many: which there are, and
// their bytes.
//
// The existing files are found once, from the checksums if sluice kept some, else from the folder's
// listing at the first question; the chunks of a shard from its index, when it is first needed. In
// a store that cannot be listed, such as a web server, a file may be there until it was asked for.
// Later changes in the store are an Error, not a mixture of old and new voxels. Any thread may call
// anything at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "io/stores/chunk_store.h"
#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/reading/chunked_array.h"
#include "io/zarr/reading/zarr_checksums.h"
#include "io/zarr/reading/zarr_shard_indices.h"
#include "src/base/threads/mutex.h"

namespace sluice {

// At 64^3 bytes each, they are a gigabyte.
inline constexpr int64_t kSampledChunks = 4096;

class ZarrChunkFiles final : public ChunkedArray {
 public:
  // `array_text`: the .zarray that `array` was parsed from. Throws Error: checksums that are
  // damaged.
  ZarrChunkFiles(StorePlace folder, ZarrArray array, std::string_view array_text);

  const ZarrArray& array() const override { return array_; }
  bool hasChecksums() const { return checksums_.has_value(); }
  // Changes with any of the checksums. Requires: hasChecksums().
  uint64_t digestOfChecksums() const;
  // The checksum record of a chunk. Requires: hasChecksums().
  const StoredChunk& stored(int64_t chunk) const;

  // There are checksums, or the store can be listed.
  bool areKnown() const override { return checksums_ || folder_.store->canList(); }
  // Throws Error when the folder cannot be listed.
  const std::vector<int64_t>& existing() override;
  // Throws Error if the checksums deny the chunk, and there is one; the index of its shard cannot
  // be read.
  bool exists(int64_t chunk) override;
  // Read and decoded. Throws Error, naming the file.
  std::shared_ptr<CountedBytes> load(int64_t chunk, ChunkMemory& memory) override;
  StoredReads storedReads(std::span<const int64_t> chunks) override;
  // Covers the checksums, which deny a changed chunk when it is read; without them the stamps of at
  // most kSampledChunks files.
  std::string stamp() const override;
  // The files as the folder lists them, whatever the checksums tell. Requires: the store can be
  // listed.
  std::vector<int64_t> onDisk() const;
  // A checksum over the stamps of at most `most` files, evenly spread over the numbers; a missing
  // file counts too. It changes when one of them is rewritten, replaced, removed or added.
  uint64_t stampChecksum(int64_t most) const;

  // Reads the stored bytes of a chunk into the memory that `room(bytes)` returns, after their
  // number was found credible, and checks the checksum if there is one. Returns how many there are
  // without a checksum that follows them; nullopt, without calling `room`: files are not known, and
  // there is no such chunk. Requires: exists(chunk). Throws Error naming the file.
  std::optional<uint64_t> read(int64_t chunk,
                               const std::function<std::span<std::byte>(uint64_t bytes)>& room);
  // The file of a chunk.
  std::string path(int64_t chunk) const;

  int distantReads() const override { return folder_.store->distantReads(); }

  // Indices of shards.
  uint64_t indexBytes() const override { return array_.shards ? array_.shardIndexBytes() : 0; }
  void holdIndices(uint64_t bytes) override { indices_->setBudget(bytes); }

  // Bytes of chunks, indices and checksums.
  uint64_t storedBytesRead() const override { return read_bytes_; }

 private:
  using Room = ChunkStore::Room;
  void list();
  void listFolder(const StorePlace& folder, std::vector<int64_t>& index,
                  std::vector<int64_t>& found) const;
  // As ChunkStore::read(), and counts the bytes. Throws Error, naming the file: it is gone, or was
  // written after the volume was opened.
  bool readFile(int64_t file, const PieceBytes& wanted, const Room& room);
  void readIndex(int64_t file, std::span<std::byte> index);
  // The place of a shard's index in its file.
  PieceBytes indexPiece() const;
  // Files that turned out not to be there, so that a server is seldom asked for them again.
  void rememberMissing(int64_t file);
  bool isRememberedMissing(int64_t file);

  const StorePlace folder_;
  const ZarrArray array_;
  std::optional<std::vector<StoredChunk>> checksums_;  // constant after construction
  std::once_flag listed_;
  std::vector<int64_t> existing_;              // constant once listed_
  std::unique_ptr<ZarrShardIndices> indices_;  // of shards
  std::atomic<uint64_t> read_bytes_{0};
  Mutex mutex_;
  std::unordered_set<int64_t> missing_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
