// BufferMemory: the memory in which a buffer under a budget keeps its blocks or chunks.
//
// Memory that the system hands out anew costs more than reading a file into it: a fault for every 4
// KiB. So memory that is given back here stays for the next piece, whatever its size, and new
// memory comes in large pages (large_pages.h). Idle memory goes back to the system if it would not
// fit in addition to a new piece: in use and idle together never exceed `limit_bytes`, as long as
// the memory in use alone does not. (Sizes are rounded up to 4 KiB, and a large page that is partly
// in use counts by that part.)
//
// Any thread. Pieces keep their memory alive: they may outlive the owner of this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "src/base/threads/mutex.h"

namespace sluice {

class BufferMemory : public std::enable_shared_from_this<BufferMemory> {
 public:
  using Piece = std::shared_ptr<std::byte[]>;
  // Smaller pieces are the allocator's: they are cheap there.
  static constexpr size_t kLeastBytes = size_t{64} << 10;

  // `limit_bytes`: idle memory goes back to the system if more is held, in use and idle.
  static std::shared_ptr<BufferMemory> make(uint64_t limit_bytes);
  ~BufferMemory();
  BufferMemory(const BufferMemory&) = delete;
  BufferMemory& operator=(const BufferMemory&) = delete;

  // Its contents are arbitrary. Throws std::bad_alloc.
  Piece take(size_t bytes);

  // Makes sure that idle memory for pieces of so many bytes together is there, if the limit allows
  // it: the next piece then need not wait for the system. Called while nobody waits.
  void makeReady(uint64_t bytes);

  // Applies from now on: for an owner that keeps bytes of another kind in the same budget.
  void setLimit(uint64_t limit_bytes);

  // Bytes in use and idle.
  uint64_t heldBytes() const;

 private:
  // Free parts of the memory, neighbours joined: position -> length.
  class Extents {
   public:
    void add(uint64_t at, uint64_t length);
    // The first one that is long enough.
    std::optional<uint64_t> take(uint64_t length);
    struct Part {
      uint64_t at, length;
    };
    // The end of the last one, of at most this length. Requires: not empty().
    Part takeLast(uint64_t most);
    bool empty() const { return lengths_.empty(); }
    uint64_t bytes() const;

   private:
    std::map<uint64_t, uint64_t> lengths_;
  };

  explicit BufferMemory(uint64_t limit_bytes);
  std::optional<uint64_t> takeExtent(uint64_t length);
  void giveBack(uint64_t at, uint64_t length);
  // Returns idle memory to the system until there is room for `length`.
  void makeRoom(uint64_t length) SLUICE_REQUIRES(mutex_);

  uint64_t mapped_bytes_ = 0;   // constant after construction; of addresses, not of memory
  std::byte* begin_ = nullptr;  // constant after construction
  mutable Mutex mutex_;
  Extents idle_ SLUICE_GUARDED_BY(mutex_);   // have memory
  Extents empty_ SLUICE_GUARDED_BY(mutex_);  // have none
  uint64_t limit_bytes_ SLUICE_GUARDED_BY(mutex_);
  uint64_t held_bytes_ SLUICE_GUARDED_BY(mutex_) = 0;
};

}  // namespace sluice
