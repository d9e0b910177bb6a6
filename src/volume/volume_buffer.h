// VolumeBuffer: level 2, the volume blocks in memory under a hard budget.
//
// The folder: here, blocks, how volumes are cut into them (block_layout.h, pyramid.h), and level 2
// itself. voxels/ has the form of voxels in levels 2 to 4, ranges/ the min-max arrays and other
// ranges of values, and passes/ what a pass over all voxels of a volume is made of.
//
// Blocks come from the VolumeSources of a volume's levels in device form, each once however many
// threads want it: the first publishes the entry and loads outside the lock, the others wait. The
// least recently used block that no one holds goes first: one that was used more than once is
// compressed and stays, in at most half of the budget, until it is the coldest of those; the others
// are dropped and read again should they be wanted. A block that makes room for one of a coarser
// level is compressed, too, so that a coarse picture costs a finer one nothing that was read. If
// the coarsest of several levels takes at most an eighth of the budget, its blocks go last among
// those of their time step, since every picture can fall back on them. A handle pins its block. The
// buffer must outlive its handles' use of the source, not the handles. All members may be called
// from any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "src/base/memory/buffer_memory.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/counters.h"
#include "src/base/threads/single_flight_cache.h"
#include "src/volume/block_layout.h"
#include "src/volume/block_name.h"
#include "src/volume/packed_block.h"
#include "src/volume/read_tally.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {

// The voxels of one block: those of its cube that exist (BlockLayout::storedVoxels), x fastest.
// Behind those of a level with spreads lie the spreads, in the same order and type.
struct VolumeBlock {
  Box3 voxels;
  DeviceType type = DeviceType::kU8;
  int numbers = 1;  // a voxel: 2 with spreads
  BufferMemory::Piece bytes;

  // The bytes of the voxels alone, which are also those of their spreads alone.
  size_t planeBytes() const { return static_cast<size_t>(voxels.count()) * bytesPerVoxel(type); }
  size_t byteCount() const { return planeBytes() * static_cast<size_t>(numbers); }
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
  // Looks at a block that was just read; the Error that it throws fails the read. Called on any
  // thread, on several at once.
  using Check = std::function<void(const BlockName& name, const VolumeBlock& block)>;

  // Whether blocks that were requested more than once are dropped or packed when their room is
  // needed.
  enum class Cold { kDropped, kPacked };
  // A level of resolution: its source, and how it is cut into blocks.
  struct Level {
    VolumeSource* source = nullptr;  // must outlive the buffer
    BlockLayout layout;
    VolumeSource* spreads = nullptr;  // CoarserLevel::spreads; must outlive the buffer
  };
  // Requires: levels not empty, blocks of one size, sources of one device form.
  VolumeBuffer(std::vector<Level> levels, uint64_t budget_bytes, Cold cold = Cold::kDropped);
  // A volume of one level.
  VolumeBuffer(VolumeSource& source, const BlockLayout& layout, uint64_t budget_bytes,
               Cold cold = Cold::kDropped);
  ~VolumeBuffer();

  // Requires: no other call is under way.
  void checkBy(Check check) { check_ = std::move(check); }

  // The blocks of `keys`, in that order; blocks of one row that follow each other in `keys` are
  // read together (rowBlocks()). Throws Error when a read fails or when the budget cannot hold
  // these blocks in addition to the blocks that other handles pin and other calls wait for,
  // Interrupted when the source does; the failed blocks are not kept. In addition to its blocks,
  // each call holds at most kScratchBytes (or one plane of a block) while it reads voxels that are
  // larger on disk than here.
  //
  // `ahead`, if given, tells for each key whether its block is only brought because it lies next to
  // others; the next call that requests it is the first to use it. Bytes and times of this call are
  // added to `tally`, which may be null.
  std::vector<VolumeBlockPtr> acquire(std::span<const BlockName> keys,
                                      const std::vector<bool>& ahead = {},
                                      ReadTally* tally = nullptr);

  // The blocks of a level that lie in one row of its source, whose ids follow each other: along x,
  // as the rows of a file do; or in a layer across z, if the source decodes parts that are wider
  // along y than a block, such as slices or slabs.
  int64_t rowBlocks(int32_t level) const { return row_blocks_[static_cast<size_t>(level)]; }

  // Whether a block is here, packed or not, so that it need not be read. Changes nothing.
  bool holds(const BlockName& key) const;

  // Reads voxels of level 0 that are not kept here, for data made from them; counted as decoded
  // like the others. Throws what the source does.
  void readPast(int64_t time, const RegionRead& region, ReadTally* tally = nullptr);

  static constexpr size_t kScratchBytes = DeviceReader::kScratchBytes;

  DeviceType type() const { return map_.type; }
  // Bytes of the largest inner block: what a budget is planned with.
  uint64_t blockBytes() const;
  CacheCounters counters() const { return blocks_.counters(); }
  void resetCounters() { blocks_.resetCounters(); }

 private:
  struct Use {
    bool used = false;    // asked for, not only ahead
    bool reused = false;  // used again, now or after an earlier load
    void note(bool ahead) {
      if (ahead) return;
      reused = reused || used;
      used = true;
    }
  };
  using Blocks = SingleFlightCache<BlockName, const VolumeBlock, BlockNameHash, Use>;
  using EntryPtr = Blocks::EntryPtr;
  // A block that is kept compressed, and one on its way back.
  struct Packed {
    BlockName key;
    Use use;
    PackedBytes bytes;
  };
  // An entry that this call brings to its end, from the source or, if it has packed bytes, from
  // these.
  struct Own {
    EntryPtr entry;
    PackedBytes packed;
  };

  // Functions that take `lock` may release it for a while.
  EntryPtr request(MutexLock& lock, const BlockName& key, bool ahead, std::vector<Own>& ours)
      SLUICE_REQUIRES(blocks_.mutex);
  bool hasRoom(uint64_t bytes) const SLUICE_REQUIRES(blocks_.mutex);
  void countPacked(int64_t bytes) SLUICE_REQUIRES(blocks_.mutex);
  // Room for a block.
  void freeSome(MutexLock& lock, const BlockName& key, uint64_t bytes)
      SLUICE_REQUIRES(blocks_.mutex);
  void packOrDrop(MutexLock& lock, const EntryPtr& victim, const BlockName& for_block)
      SLUICE_REQUIRES(blocks_.mutex);
  // Whether a block goes last while this time step is in use.
  bool staysLongest(const BlockName& name, int64_t time) const {
    return keeps_coarsest_ && name.level + size_t{1} == levels_.size() && name.time == time;
  }
  void keepPacked(const EntryPtr& entry, PackedBytes bytes) SLUICE_REQUIRES(blocks_.mutex);
  void dropColdest() SLUICE_REQUIRES(blocks_.mutex);

  std::shared_ptr<VolumeBlock> emptyBlock(const BlockName& key) const;
  void loadOwn(std::span<Own> ours, ReadTally* tally) noexcept;
  void unpackAndFinish(Own& own, ReadTally* tally) noexcept;
  // Entries of one row of blocks that this call reads; their state tells the outcome.
  void loadAndFinish(std::span<const Own> run, ReadTally* tally) noexcept;
  std::vector<std::shared_ptr<VolumeBlock>> load(std::span<const Own> run, ReadTally* tally);
  void countRead(const DeviceReader& reader, uint64_t bytes, ReadTally* tally)
      SLUICE_EXCLUDES(blocks_.mutex);
  // The exception that is being handled, as an Error that names the block; a library's own type is
  // translated.
  std::exception_ptr failureOf(const BlockName& key) const noexcept;

  const Level& levelOf(const BlockName& name) const {
    return levels_[static_cast<size_t>(name.level)];
  }
  // Numbers a voxel.
  int numbersOf(const BlockName& name) const { return levelOf(name).spreads == nullptr ? 1 : 2; }
  Box3 storedVoxels(const BlockName& name) const {
    const BlockLayout& layout = levelOf(name).layout;
    return layout.storedVoxels(layout.indexOf(name.block));
  }

  const std::vector<Level> levels_;
  const std::vector<int64_t>
      row_blocks_;      // of each level, see rowBlocks()             // constant after construction
  const ValueMap map_;  // constant after construction
  const bool packs_;    // constant after construction
  const bool keeps_coarsest_;                   // constant after construction
  Check check_;                                 // may be null; constant once blocks are read
  const std::shared_ptr<BufferMemory> memory_;  // memory of the unpacked blocks
  Blocks blocks_;                               // unpacked blocks
  // Packed entries, most recently packed first.
  std::list<Packed> cold_ SLUICE_GUARDED_BY(blocks_.mutex);
  std::unordered_map<BlockName, std::list<Packed>::iterator, BlockNameHash> cold_by_key_
      SLUICE_GUARDED_BY(blocks_.mutex);
  uint64_t cold_bytes_ SLUICE_GUARDED_BY(blocks_.mutex) = 0;  // bytes of cold_
  uint64_t packed_bytes_ SLUICE_GUARDED_BY(blocks_.mutex) =
      0;  // bytes of cold_ and of the blocks being unpacked
  // A thread packs: one at a time, with scratch for one block.
  bool packing_ SLUICE_GUARDED_BY(blocks_.mutex) = false;
};

}  // namespace sluice
