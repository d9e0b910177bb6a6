// VolumeBuffer: level 2, the volume blocks in memory under a hard budget.
//
// Blocks come from a VolumeSource in device form, each once however many threads want it: the first
// publishes the entry and loads outside the lock, the others wait. The least recently used block
// that no one holds goes first: one that was used more than once is compressed and stays, in
// at most half of the budget, until it is the coldest of those; the others are dropped and read
// again should they be wanted. A handle pins its block. The buffer must outlive its handles' use of
// the source, not the handles. All members may be called from any thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "src/base/buffer_memory.h"
#include "src/base/counters.h"
#include "src/base/volume_source.h"
#include "src/volume/block_layout.h"
#include "src/volume/device_voxel.h"

namespace sluice {

struct BlockKey {
  int64_t time = 0;
  int64_t block = 0;  // id in the layout
  friend bool operator==(const BlockKey&, const BlockKey&) = default;
};
struct BlockKeyHash {
  size_t operator()(const BlockKey& key) const {
    return static_cast<size_t>((static_cast<uint64_t>(key.time) * 0x9e3779b97f4a7c15U) ^
                               (static_cast<uint64_t>(key.block) * 0xff51afd7ed558ccdU));
  }
};

// The voxels of one block: those of its cube that exist (BlockLayout::storedVoxels), x fastest.
struct VolumeBlock {
  Box3 voxels;
  DeviceType type = DeviceType::kU8;
  BufferMemory::Piece bytes;

  size_t byteCount() const { return static_cast<size_t>(voxels.count()) * bytesPerVoxel(type); }
  // Bytes in front of a voxel. Requires: voxels.contains(voxel).
  size_t offsetOf(Vec3i voxel) const {
    const Vec3i local = voxel - voxels.lo, size = voxels.size();
    return static_cast<size_t>((local.z * size.y + local.y) * size.x + local.x) *
           bytesPerVoxel(type);
  }
  const std::byte* at(Vec3i voxel) const { return bytes.get() + offsetOf(voxel); }
};
using VolumeBlockPtr = std::shared_ptr<const VolumeBlock>;

class VolumeBuffer {
 public:
  // What happens to blocks that were asked for more than once when their room is needed.
  enum class Cold { kDropped, kPacked };
  // `source` must outlive the buffer.
  VolumeBuffer(VolumeSource& source, const BlockLayout& layout, uint64_t budget_bytes,
               Cold cold = Cold::kDropped);
  ~VolumeBuffer();

  // The blocks of `keys`, in that order; those of one row along x that follow each other in `keys`
  // are read together.
  // Throws Error when a read fails or when the budget cannot hold these blocks beside those that
  // other handles pin and other calls wait for, Interrupted when the source does; the failed blocks
  // are not kept. Beside its blocks each call holds at most kScratchBytes (or one plane of a block)
  // while it reads voxels that are larger on disk than here.
  //
  // `ahead`, where given, says of each key whether its block is only brought because it lies beside
  // the others: the next call that wants it is the first to use it.
  std::vector<VolumeBlockPtr> acquire(std::span<const BlockKey> keys,
                                      const std::vector<bool>& ahead = {});

  static constexpr size_t kScratchBytes = size_t{256} << 10;

  // Bytes of an inner block: what a budget is planned with.
  uint64_t blockBytes() const;
  CacheCounters counters() const;
  void resetCounters();
  // Seconds that all threads together spent reading and converting since construction.
  double readSeconds() const { return static_cast<double>(read_ns_.load()) * 1e-9; }
  double decodeSeconds() const { return static_cast<double>(decode_ns_.load()) * 1e-9; }

 private:
  struct Entry;
  using EntryPtr = std::shared_ptr<Entry>;

  // These require mutex_ to be held. With `lock` in the arguments they may give it up for a while.
  EntryPtr request(std::unique_lock<std::mutex>& lock, const BlockKey& key, bool ahead,
                   std::vector<EntryPtr>& ours);
  bool hasRoom(uint64_t bytes) const;
  void countPacked(int64_t bytes);
  void freeSome(std::unique_lock<std::mutex>& lock, uint64_t wanted_bytes);
  void packOrDrop(std::unique_lock<std::mutex>& lock, const EntryPtr& victim);
  void drop(const EntryPtr& victim, std::list<EntryPtr>& from);
  void hold(const EntryPtr& entry, VolumeBlockPtr block);

  std::shared_ptr<VolumeBlock> emptyBlock(const BlockKey& key) const;
  void loadOwn(std::span<const EntryPtr> ours);
  void unpackAndFinish(const EntryPtr& entry);
  // Entries of one row of blocks that this call reads; their state says how it went.
  void loadAndFinish(std::span<const EntryPtr> run);
  std::vector<std::shared_ptr<VolumeBlock>> load(std::span<const EntryPtr> run);
  void readInPlace(int64_t time, std::span<const std::shared_ptr<VolumeBlock>> blocks);
  void readThroughScratch(int64_t time, VolumeBlock& block);

  VolumeSource& source_;                        // constant after construction
  const BlockLayout layout_;                    // constant after construction
  const ValueMap map_;                          // constant after construction
  const bool packs_;                            // constant after construction
  const std::shared_ptr<BufferMemory> memory_;  // of the blocks as they are
  std::atomic<int64_t> read_ns_{0}, decode_ns_{0};
  mutable std::mutex mutex_;
  std::condition_variable loaded_;
  // Guarded by mutex_.
  std::unordered_map<BlockKey, EntryPtr, BlockKeyHash> entries_;
  std::list<EntryPtr> recent_;  // resident as they are, most recently used first
  std::list<EntryPtr> cold_;    // resident packed, most recently packed first
  uint64_t cold_bytes_ = 0;     // of these
  uint64_t packed_bytes_ = 0;   // of these and those that are being unpacked
  bool packing_ = false;        // a thread packs: one at a time, with scratch for one block
  std::unordered_set<BlockKey, BlockKeyHash> seen_;
  uint64_t reserved_bytes_ = 0;  // of loads under way
  CacheCounters counters_;
};

}  // namespace sluice
