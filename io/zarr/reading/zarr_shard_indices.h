// ZarrShardIndices: the indices of the shards that were used last, within a number of bytes.
//
// An index says where each chunk of its shard lies. It is read once and kept as long as there is
// room. Any thread may call anything at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/reading/zarr_chunk_cache.h"

namespace sluice {

// The bytes of a chunk in its file.
struct ZarrChunkPlace {
  uint64_t offset = 0, bytes = 0;
};

class ZarrShardIndices {
 public:
  // Reads the index of a file, as stored. Throws Error, naming the file.
  using Read = std::function<void(int64_t file, std::span<std::byte> index)>;

  // `array` must outlive this. Requires: array.shards.
  ZarrShardIndices(const ZarrArray& array, uint64_t budget_bytes, Read read);

  // An index of a shard without a chunk.
  static void setMissing(std::span<std::byte> index);

  // The entry of a chunk of the shard in an index as stored; nullopt: the shard has no such chunk.
  static std::optional<ZarrChunkPlace> entryOf(const ZarrArray& array,
                                               std::span<const std::byte> index, int64_t chunk);

  // nullopt: the shard has no such chunk. Throws what `read` does.
  std::optional<ZarrChunkPlace> find(ZarrArray::Place place);

  // Holds two indices for each thread inside find(), whatever the budget.
  void setBudget(uint64_t bytes) { indices_.setBudget(bytes); }
  const ChunkMemory& held() const { return indices_.held(); }

 private:
  const ZarrArray& array_;
  ZarrChunkCache indices_;  // by the number of the file
};

}  // namespace sluice
