// TextureBuffer: level 3, the texels of chunks in memory under a hard budget.
//
// A chunk is filled from its volume blocks on worker threads, kept least recently used first out,
// and found again by its name (chunk_names.h) whatever plan asks. The chunks that a frame will draw
// next are begun ahead: begin() starts to fill, finish() waits, and cancel() drops chunks that the
// frame no longer wants. One thread calls, the workers fill; a handle pins its chunk. Its
// destructor waits for fillings under way.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "src/base/memory/buffer_memory.h"
#include "src/base/threads/counters.h"
#include "src/base/threads/single_flight_cache.h"
#include "src/base/threads/worker_pool.h"
#include "src/device/chunk_texels.h"
#include "src/texture/texture_plan.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

struct ReadRun;

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
  // Begins to fill these chunks named `names` (of all chunks) on the worker threads; waits for the
  // room of fillings that are no longer wanted. Throws Error when the budget cannot hold them in
  // addition to the pinned chunks. The plan may go when this returns.
  //
  // `soon` are chunks that will be asked for next. Their blocks are read together with blocks of
  // the same row along x that are read now, since rows of a file lie together, as far as level 2
  // holds them.
  BatchPtr begin(const TexturePlan& plan, const ChunkNameList& names,
                 std::span<const ChunkPosition> chunks, std::span<const ChunkPosition> soon = {},
                 const ReadPurpose& purpose = {});
  // The same without waiting; null, and nothing begun, for want of room.
  BatchPtr tryBegin(const TexturePlan& plan, const ChunkNameList& names,
                    std::span<const ChunkPosition> chunks, std::span<const ChunkPosition> soon = {},
                    const ReadPurpose& purpose = {});
  // The texels in the order asked for. Helps to fill, then waits for the workers. Throws Error
  // when a block cannot be read, Interrupted when it was stopped; the chunks are not kept then.
  std::vector<ChunkTexelsPtr> finish(const BatchPtr& batch);
  // The same but waits no longer than until `deadline`, and does not help: null for those that are
  // not filled then. The batch goes on, and is still to be finished or cancelled.
  std::vector<ChunkTexelsPtr> waitUntil(const BatchPtr& batch,
                                        std::chrono::steady_clock::time_point deadline);
  // Fillings that no worker has begun are not read, unless another batch wants a chunk of this one.
  void cancel(const BatchPtr& batch);
  // Returns when nothing is being filled. Requires: every batch is finished or cancelled.
  void waitUntilIdle();
  // begin and finish.
  std::vector<ChunkTexelsPtr> acquire(const TexturePlan& plan, const ChunkNameList& names,
                                      std::span<const ChunkPosition> chunks);

  // Makes memory ready for about `bytes` of new texels, on a worker thread: for when a frame is
  // done and nobody waits. At most kMostReadyBytes, and none beyond the budget.
  void makeReady(uint64_t bytes);
  static constexpr uint64_t kMostReadyBytes = uint64_t{64} << 20;

  CacheCounters counters() const { return chunks_.counters(); }
  void resetCounters() { chunks_.resetCounters(); }

 private:
  // A chunk that the workers fill, until its last block is in it.
  struct Underway {
    std::shared_ptr<ChunkTexels> texels;
    size_t fillings_left = 0;
    std::exception_ptr failure = {};  // first filling that failed or was skipped
  };
  using Chunks = SingleFlightCache<ChunkName, const ChunkTexels, std::hash<ChunkName>, Underway>;
  using EntryPtr = Chunks::EntryPtr;
  struct Filling;

  bool makeRoomFor(const TexturePlan& plan, const ChunkNameList& names,
                   std::span<const ChunkPosition> chunks) SLUICE_REQUIRES(chunks_.mutex);
  EntryPtr publish(const TexturePlan& plan, const Chunk& chunk, ChunkName name,
                   std::vector<Filling>& fillings) SLUICE_REQUIRES(chunks_.mutex);
  void settle(const EntryPtr& entry) SLUICE_REQUIRES(chunks_.mutex);
  void skipRest(Batch& batch, const std::exception_ptr& why) SLUICE_REQUIRES(chunks_.mutex);
  // Drops a batch that no worker knows of yet. Called while an exception is handled.
  void abandon(Batch& batch) SLUICE_REQUIRES(chunks_.mutex);
  std::vector<BlockName> blocksSoon(const TexturePlan& plan, const ChunkNameList& names,
                                    std::span<const ChunkPosition> soon) const
      SLUICE_REQUIRES(chunks_.mutex);

  void planRuns(Batch& batch, std::vector<Filling> fillings, std::vector<BlockName> soon) const;
  void startHelpers(const BatchPtr& batch);
  // On a worker thread; false, and nothing started, for want of memory.
  template <class Job>
  bool startWorker(Job job);
  void helperIsDone();
  void work(Batch& batch);
  void fill(Batch& batch, const ReadRun& run);

  VolumeBuffer& blocks_;
  WorkerPool& pool_;
  const std::shared_ptr<BufferMemory> memory_;  // holds the texels
  Chunks chunks_;
  int64_t workers_under_way_ SLUICE_GUARDED_BY(chunks_.mutex) = 0;
  size_t runs_under_way_ SLUICE_GUARDED_BY(chunks_.mutex) = 0;  // being read and copied
};

}  // namespace sluice
