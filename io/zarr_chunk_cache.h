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

namespace sluice {

// Bytes held, now and at most so far.
class HeldBytes {
 public:
  void add(uint64_t bytes);
  void remove(uint64_t bytes) { now_ -= bytes; }
  uint64_t now() const { return now_; }
  uint64_t peak() const { return peak_; }

 private:
  std::atomic<uint64_t> now_{0}, peak_{0};
};

// Memory that is counted while it lives. Not set to anything.
class CountedBytes {
 public:
  CountedBytes(uint64_t bytes, HeldBytes& held);
  ~CountedBytes() { held_.remove(size_); }
  CountedBytes(const CountedBytes&) = delete;
  CountedBytes& operator=(const CountedBytes&) = delete;

  std::span<std::byte> span() { return {bytes_.get(), size_}; }
  std::span<const std::byte> span() const { return {bytes_.get(), size_}; }

 private:
  const uint64_t size_;
  HeldBytes& held_;
  const std::unique_ptr<std::byte[]> bytes_;
};

class ZarrChunkCache {
 public:
  using Chunk = std::shared_ptr<const CountedBytes>;
  // Makes the decoded bytes of a chunk. May take about as much again meanwhile, counted in `held`.
  using Decode = std::function<Chunk(int64_t chunk, HeldBytes& held)>;

  // Holds at most `budget_bytes`, but two chunks for each thread inside get() and one for each
  // Chunk that is still in use, whatever the budget.
  ZarrChunkCache(uint64_t chunk_bytes, uint64_t budget_bytes, Decode decode);

  // The chunk stays as long as the result does. Throws what `decode` throws, to all who waited; the
  // next call tries anew.
  Chunk get(int64_t chunk);

  void setBudget(uint64_t budget_bytes);
  const HeldBytes& held() const { return held_; }

 private:
  struct Entry {
    Chunk chunk;                      // null while it is decoded
    std::exception_ptr failure;       // instead of the chunk
    std::list<int64_t>::iterator at;  // in used_, once decoded
  };

  void makeRoom();  // Requires: mutex_ held

  const uint64_t chunk_bytes_;
  const Decode decode_;
  HeldBytes held_;
  std::mutex mutex_;
  uint64_t budget_bytes_;  // guarded by mutex_
  std::condition_variable decoded_;
  std::unordered_map<int64_t, std::shared_ptr<Entry>> entries_;  // guarded by mutex_
  std::list<int64_t> used_;                                      // guarded by mutex_; last in front
  uint64_t decoding_ = 0;                                        // guarded by mutex_; how many
};

}  // namespace sluice
