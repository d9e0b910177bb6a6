// TextureBuffer: level 3, the texels of chunks in memory under a hard budget.
//
// A chunk is filled from its volume blocks on all worker threads when it is first asked for, kept
// least recently used first out, and found again by its name (chunk_names.h) whatever plan asks.
// acquire() is called from one thread; the workers it starts are done when it returns. A handle
// pins its chunk.
#pragma once

#include <atomic>
#include <cstddef>
#include <list>
#include <memory>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "src/base/counters.h"
#include "src/base/worker_pool.h"
#include "src/texture/texture_plan.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

// Texels of a chunk in whole pages, x fastest.
struct ChunkTexels {
  Vec3i storage_vox;
  size_t byte_count = 0;
  std::unique_ptr<std::byte[]> bytes;
  std::span<std::byte> span() const { return {bytes.get(), byte_count}; }
};
using ChunkTexelsPtr = std::shared_ptr<const ChunkTexels>;

class TextureBuffer {
 public:
  // `blocks` and `pool` must outlive the buffer.
  TextureBuffer(VolumeBuffer& blocks, WorkerPool& pool, uint64_t budget_bytes);

  // Bytes of a chunk of the plan, in whole pages.
  static uint64_t bytesOf(const TexturePlan& plan, const Chunk& chunk);
  // The texels of these chunks (positions in plan.chunks) named `names` (of all chunks), in that
  // order. Throws Error when a block cannot be read or the budget cannot hold them at once.
  std::vector<ChunkTexelsPtr> acquire(const TexturePlan& plan, std::span<const uint64_t> names,
                                      std::span<const int64_t> chunks);

  const CacheCounters& counters() const { return counters_; }
  void resetCounters() { counters_.reset(); }
  // Seconds that all threads together spent copying since construction.
  double copySeconds() const { return static_cast<double>(copy_ns_.load()) * 1e-9; }

 private:
  struct Entry {
    uint64_t name;
    std::shared_ptr<ChunkTexels> texels;
  };
  struct Filling;

  void makeRoom(uint64_t bytes);
  void fill(const TexturePlan& plan, const std::vector<Filling>& fillings);

  VolumeBuffer& blocks_;
  WorkerPool& pool_;
  std::list<Entry> recent_;  // most recently used first
  std::unordered_map<uint64_t, std::list<Entry>::iterator> entries_;
  std::unordered_set<uint64_t> seen_;
  CacheCounters counters_;
  std::atomic<int64_t> copy_ns_{0};
};

}  // namespace sluice
