// ZarrChunkCache: decoded chunks of the arrays of a store, the ones used last, within a number of
// bytes for all arrays together.
//
// The blocks that are read of a volume share chunks with their neighbours; without this each chunk
// would be decoded up to 8 times. A chunk that two threads want at once is decoded by the first,
// and the other waits. Any thread may call anything at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/base/memory/aligned_array.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/single_flight_cache.h"

namespace sluice {

// Memory for chunks, taken and given back by the thousand. Memory that is given back is kept for
// the next chunk as long as all of it is within a limit, since the system takes longer to map and
// clear memory than a chunk to decode.
class ChunkMemory {
 public:
  struct Buffer {
    AlignedArray<std::byte> bytes;  // not set to anything
    uint64_t size = 0;
  };

  explicit ChunkMemory(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  // A buffer of `bytes`, or of up to twice as many.
  Buffer take(uint64_t bytes);
  void give(Buffer buffer);
  // Frees the memory kept beyond it.
  void setLimit(uint64_t limit_bytes);
  // Bytes taken and kept, now and at most so far.
  uint64_t now() const { return now_; }
  uint64_t peak() const { return peak_; }

 private:
  std::atomic<uint64_t> now_{0}, peak_{0};  // written under mutex_
  Mutex mutex_;
  uint64_t limit_bytes_ SLUICE_GUARDED_BY(mutex_);
  std::vector<Buffer> kept_ SLUICE_GUARDED_BY(mutex_);
};

// A piece of it, given back at the end.
class CountedBytes {
 public:
  CountedBytes(uint64_t bytes, ChunkMemory& memory)
      : size_(bytes), memory_(memory), buffer_(memory.take(bytes)) {}
  ~CountedBytes() { memory_.give(std::move(buffer_)); }
  CountedBytes(const CountedBytes&) = delete;
  CountedBytes& operator=(const CountedBytes&) = delete;

  std::span<std::byte> span() { return {buffer_.bytes.get(), size_}; }
  std::span<const std::byte> span() const { return {buffer_.bytes.get(), size_}; }

 private:
  const uint64_t size_;
  ChunkMemory& memory_;
  ChunkMemory::Buffer buffer_;
};

class ZarrChunkCache {
 public:
  using Chunk = std::shared_ptr<const CountedBytes>;
  // Makes the decoded bytes of a chunk. May take about as much again meanwhile, from the same
  // `memory`.
  using Decode = std::function<Chunk(int64_t chunk, ChunkMemory& memory)>;

  // A chunk of one of the arrays.
  struct Key {
    int array = 0;  // see addArray()
    int64_t chunk = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };

  // Holds at most `budget_bytes`, but two chunks for each thread inside get() and one for each
  // Chunk that is still in use, whatever the budget.
  explicit ZarrChunkCache(uint64_t budget_bytes);

  // Adds an array with chunks of `chunk_bytes`. Returns its number, counted from 0. To be called
  // while no thread is inside get().
  int addArray(uint64_t chunk_bytes, Decode decode);
  // The chunk stays as long as the result does. A failure of the array's `decode` is thrown to
  // every thread that waited; the next call tries again.
  // With kLeave, null is returned if another thread is decoding the chunk.
  Chunk get(const Key& key, IfLoading if_loading = IfLoading::kWait);
  CacheCounters counters() const { return chunks_.counters(); }

  // Applies at once: chunks that nobody uses go until the rest fits.
  void setBudget(uint64_t budget_bytes);
  const ChunkMemory& held() const { return memory_; }

 private:
  struct KeyHash {
    size_t operator()(const Key& key) const {
      // Arrays have far fewer than 2^48 chunks.
      return std::hash<uint64_t>()(static_cast<uint64_t>(key.chunk) ^
                                   static_cast<uint64_t>(key.array) << 48);
    }
  };
  using Chunks = SingleFlightCache<Key, const CountedBytes, KeyHash>;
  struct Array {
    uint64_t counted_bytes = 0;  // of a chunk
    Decode decode;
  };

  std::vector<Array> arrays_;  // constant after the last addArray()
  ChunkMemory memory_;
  Chunks chunks_;
};

}  // namespace sluice
