// Residency: levels 2 to 4 of one volume, of all its levels of resolution, and how they work
// together, across frames and time steps: the volume buffer, the texture buffer with the threads
// that fill it, the model of the texture cache with the device that obeys it, their budgets and the
// names of chunks.
//
// Data that frames may ask for again is kept as long as there is room for it; data that can no
// longer be asked for is dropped. Used on one thread, the device's; the readers work inside the
// buffers.
#pragma once

#include <cstdint>
#include <span>

#include "cache/model/texture_cache.h"
#include "src/base/threads/worker_pool.h"
#include "src/device/device.h"
#include "src/index/box_store.h"
#include "src/render/frame/frame_plan.h"
#include "src/render/session/budgets.h"
#include "src/texture/chunk_names.h"
#include "src/texture/texture_buffer.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

struct ResidencyOptions {
  PageGeometry page;          // bytes_per_voxel of the volume's device form
  uint64_t memory_bytes = 0;  // budget of levels 2 and 3, and of level 4 if textures are in memory
  PolicyKind policy = PolicyKind::kLru;
  uint64_t seed = 1;                         // for the random policy
  Partition partition = Partition::kBlocks;  // kBoxes: a share of the memory is for growing boxes
  uint64_t beside_bytes = 0;  // part of memory_bytes that others hold: min-max arrays
};

class Residency {
 public:
  // Serves all time steps that have the sources and layouts of `step`. These sources and `device`
  // must outlive it. `threads`: of the program; there are at least as many readers. `first_name`:
  // of the first chunk. Throws Error when the memory is too little.
  Residency(const TimeStep& step, Device& device, const ResidencyOptions& options, int threads,
            int64_t first_name);
  // The device outlives us: it is left without our chunks.
  ~Residency();
  Residency(const Residency&) = delete;
  Residency& operator=(const Residency&) = delete;

  const Budgets& budgets() const { return budgets_; }
  VolumeBuffer& blocks() { return blocks_; }
  const VolumeBuffer& blocks() const { return blocks_; }
  TextureBuffer& chunks() { return chunks_; }
  const TextureBuffer& chunks() const { return chunks_; }
  const TextureCache& cache() const { return cache_; }
  // Whether level 4 holds the chunk.
  bool isResident(ChunkName name) const { return cache_.contains(modelId(name)); }
  ChunkNames& names() { return names_; }
  const ChunkNames& names() const { return names_; }
  // Voxels for growing boxes, which level 2 counts and does not keep.
  BoxStore::ReadFor readPast() {
    return [this](int64_t time, const RegionRead& region, const ReadPurpose& purpose) {
      blocks_.readPast(time, region, purpose.tally.get());
    };
  }
  WorkerPool& readers() { return readers_; }

  // The device's id of a chunk.
  uint64_t idOf(ChunkName name) const { return first_id_ + modelId(name); }
  ChunkName nameOf(uint64_t id) const { return ChunkName(static_cast<int64_t>(id - first_id_)); }

  struct Made {
    uint64_t pages = 0;         // pages that were loaded; 0: the chunk was resident
    uint64_t copied_bytes = 0;  // by the device
    double seconds = 0;         // time taken
  };
  // Requests a chunk of the plan from level 4, which stays until unpinAll(): the model decides
  // which chunks are evicted for it, and the device obeys (design, point 5). `texels` may be null
  // if it is resident. Throws Error when the cache cannot hold it in addition to the pinned ones.
  Made makeResident(const FramePlan& plan, ChunkPosition chunk, const ChunkTexelsPtr& texels);
  void unpinAll() { cache_.unpinAll(); }

  // Forgets the names that neither this plan nor a level uses, when they have become many.
  void forgetUnused(const FramePlan& plan);

 private:
  // Frees the chunks that the model has evicted: all of them, even if the frame ends on the way.
  void evict(std::span<const ChunkId> ids);
  // The model's id of a chunk.
  static ChunkId modelId(ChunkName name) { return static_cast<ChunkId>(name.value()); }

  Device& device_;
  const Budgets budgets_;
  VolumeBuffer blocks_;
  WorkerPool readers_;
  TextureBuffer chunks_;
  TextureCache cache_;
  ChunkNames names_;
  const uint64_t first_id_;  // first of our ids on the device
};

}  // namespace sluice
