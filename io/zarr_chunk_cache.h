// ZarrChunkCache: decoded chunks, the ones used last, within a number of bytes.
//
// The blocks that are read of a volume share chunks with their neighbours; without this each chunk
// would be decoded up to 8 times. A chunk that two threads want at once is decoded by the first,
// and the other waits. Any thread may call anything at once.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sluice {

// Memory for chunks, taken and given back by the thousand: what is given back is kept for the next
// as long as all of it is within a limit, as the system takes longer to map and clear memory than a
// chunk to decode.
class ChunkMemory {
 public:
  struct Buffer {
    std::unique_ptr<std::byte[]> bytes;  // not set to anything
    uint64_t size = 0;
  };

  explicit ChunkMemory(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  // Of `bytes` or somewhat more.
  Buffer take(uint64_t bytes);
  void give(Buffer buffer);
  // Frees what is kept beyond it.
  void setLimit(uint64_t limit_bytes);
  // Bytes taken and kept, now and at most so far.
  uint64_t now() const { return now_; }
  uint64_t peak() const { return peak_; }

 private:
  std::atomic<uint64_t> now_{0}, peak_{0};  // written under mutex_
  std::mutex mutex_;
  uint64_t limit_bytes_;      // guarded by mutex_
  std::vector<Buffer> kept_;  // guarded by mutex_
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

  // Holds at most `budget_bytes`, but two chunks for each thread inside get() and one for each
  // Chunk that is still in use, whatever the budget.
  ZarrChunkCache(uint64_t chunk_bytes, uint64_t budget_bytes, Decode decode);

  // The chunk stays as long as the result does. Throws what `decode` throws, to all who waited; the
  // next call tries anew.
  Chunk get(int64_t chunk);

  void setBudget(uint64_t budget_bytes);
  const ChunkMemory& held() const { return memory_; }

 private:
  struct Entry {
    Chunk chunk;                      // null while it is decoded
    std::exception_ptr failure;       // instead of the chunk
    std::list<int64_t>::iterator at;  // in used_, once decoded
  };

  void makeRoom();  // Requires: mutex_ held

  const uint64_t chunk_bytes_;
  const Decode decode_;
  ChunkMemory memory_;
  std::mutex mutex_;
  uint64_t budget_bytes_;  // guarded by mutex_
  std::condition_variable decoded_;
  std::unordered_map<int64_t, std::shared_ptr<Entry>> entries_;  // guarded by mutex_
  std::list<int64_t> used_;                                      // guarded by mutex_; last in front
  uint64_t decoding_ = 0;                                        // guarded by mutex_; how many
};

}  // namespace sluice
