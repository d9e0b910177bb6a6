// TextureBuffer: level 3, the texels of chunks in memory under a hard budget.
//
// A chunk is filled from its volume blocks on worker threads, kept least recently used first out,
// and found again by its name (chunk_names.h) whatever plan asks. What a frame will draw next is
// begun ahead: begin() starts to fill, finish() waits, and what the frame no longer wants is
// cancelled. One thread calls, the workers fill; a handle pins its chunk. Waits for what is under
// way when it is destroyed.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "src/base/buffer_memory.h"
#include "src/base/counters.h"
#include "src/base/worker_pool.h"
#include "src/texture/texture_plan.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

struct ReadRun;

// Texels of a chunk in whole pages, x fastest.
struct ChunkTexels {
  Vec3i storage_vox;
  size_t byte_count = 0;
  BufferMemory::Piece bytes;
  std::span<std::byte> span() const { return {bytes.get(), byte_count}; }
};
using ChunkTexelsPtr = std::shared_ptr<const ChunkTexels>;

class TextureBuffer {
 public:
  // `blocks` and `pool` must outlive the buffer.
  TextureBuffer(VolumeBuffer& blocks, WorkerPool& pool, uint64_t budget_bytes);
  ~TextureBuffer();

  // Bytes of a chunk of the plan, in whole pages.
  static uint64_t bytesOf(const TexturePlan& plan, const Chunk& chunk);

  // Chunks asked for together; pinned until it is finished or cancelled, which each must be.
  class Batch;
  using BatchPtr = std::shared_ptr<Batch>;
  // Begins to fill these chunks (positions in plan.chunks) named `names` (of all chunks) on the
  // worker threads; waits for the room of what is being filled and no longer wanted. Throws Error
  // when the budget cannot hold them beside what is pinned. The plan may go when this returns.
  //
  // `soon` are chunks that will be asked for next: their blocks are read with those of the same row
  // along x that are read now, since rows of a file lie together, as far as level 2 holds them.
  BatchPtr begin(const TexturePlan& plan, std::span<const uint64_t> names,
                 std::span<const int64_t> chunks, std::span<const int64_t> soon = {});
  // The same without waiting; null, and nothing begun, for want of room.
  BatchPtr tryBegin(const TexturePlan& plan, std::span<const uint64_t> names,
                    std::span<const int64_t> chunks, std::span<const int64_t> soon = {});
  // The texels in the order asked for. Helps to fill, then waits for the workers. Throws Error or
  // Interrupted when a block cannot be read; the chunks are not kept then.
  std::vector<ChunkTexelsPtr> finish(const BatchPtr& batch);
  // The same but waits no longer than until `deadline`, and does not help: null for those that are
  // not filled then. The batch goes on, and is still to be finished or cancelled.
  std::vector<ChunkTexelsPtr> waitUntil(const BatchPtr& batch,
                                        std::chrono::steady_clock::time_point deadline);
  // What no worker has begun to read will not be read, unless another batch wants a chunk of this.
  void cancel(const BatchPtr& batch);
  // Returns when nothing is being filled. Requires: every batch is finished or cancelled.
  void waitUntilIdle();
  // begin and finish.
  std::vector<ChunkTexelsPtr> acquire(const TexturePlan& plan, std::span<const uint64_t> names,
                                      std::span<const int64_t> chunks);

  CacheCounters counters() const;
  void resetCounters();
  // Seconds that all threads together spent copying since construction.
  double copySeconds() const { return static_cast<double>(copy_ns_.load()) * 1e-9; }

 private:
  struct Entry;
  using EntryPtr = std::shared_ptr<Entry>;
  struct Filling;

  // These require mutex_ to be held.
  bool makeRoom(uint64_t bytes);
  EntryPtr publish(const TexturePlan& plan, const Chunk& chunk, uint64_t name);
  void settle(const EntryPtr& entry, size_t fillings);
  void skipRest(Batch& batch, const std::exception_ptr& why);
  static void unpin(Batch& batch);

  std::vector<int64_t> blocksSoon(const TexturePlan& plan, std::span<const uint64_t> names,
                                  std::span<const int64_t> soon) const;
  void planRuns(Batch& batch, std::vector<Filling> fillings, std::vector<int64_t> soon,
                int64_t blocks_a_row) const;
  void work(Batch& batch);
  void fill(Batch& batch, const ReadRun& run);

  VolumeBuffer& blocks_;
  WorkerPool& pool_;
  const std::shared_ptr<BufferMemory> memory_;  // of the texels
  std::atomic<int64_t> copy_ns_{0};
  mutable std::mutex mutex_;
  std::condition_variable settled_;
  // Guarded by mutex_.
  std::list<EntryPtr> recent_;  // filled ones, most recently used first
  std::unordered_map<uint64_t, EntryPtr> entries_;
  std::unordered_set<uint64_t> seen_;
  uint64_t reserved_bytes_ = 0;  // of chunks being filled
  int64_t workers_under_way_ = 0;
  size_t runs_under_way_ = 0;  // being read and copied
  CacheCounters counters_;
};

}  // namespace sluice
