#include "io/zarr/reading/zarr_shard_indices.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "io/files/swap_bytes.h"
#include "io/zarr/reading/crc32c.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Offset and size of a chunk that is not there.
constexpr uint64_t kMissing = std::numeric_limits<uint64_t>::max();

}  // namespace

ZarrShardIndices::ZarrShardIndices(const ZarrArray& array, uint64_t budget_bytes, Read read)
    : array_(array), indices_(budget_bytes) {
  indices_.addArray(
      array.shardIndexBytes(),
      [read = std::move(read), bytes = array.shardIndexBytes()](int64_t file, ChunkMemory& memory) {
        auto index = std::make_shared<CountedBytes>(bytes, memory);
        read(file, index->span());
        return index;
      });
}

void ZarrShardIndices::setMissing(std::span<std::byte> index) {
  std::fill(index.begin(), index.end(), std::byte{0xff});
}

std::optional<ZarrChunkPlace> ZarrShardIndices::find(ZarrArray::Place place) {
  return entryOf(array_, indices_.get({0, place.file})->span(), place.chunk);
}

std::optional<ZarrChunkPlace> ZarrShardIndices::entryOf(const ZarrArray& array,
                                                        std::span<const std::byte> index,
                                                        int64_t chunk) {
  std::array<uint64_t, 2> entry{};
  std::memcpy(entry.data(), index.data() + sizeof entry * static_cast<size_t>(chunk), sizeof entry);
  if (array.shards->byte_order != std::endian::native)
    swapBytes(std::as_writable_bytes(std::span(entry)), sizeof(uint64_t));
  if (entry[0] == kMissing && entry[1] == kMissing) return std::nullopt;
  return ZarrChunkPlace{entry[0], entry[1]};
}

}  // namespace sluice
