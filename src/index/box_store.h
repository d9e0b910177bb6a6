// BoxStore: the boxes of requested blocks, from the volume's index if they are kept there,
// otherwise made from the voxels and kept for the next time.
//
// The index is read and written in pieces of some hundred blocks, so that a frame that sees a
// corner of a volume reads that corner's boxes. In memory are the trees of blocks asked for, the
// longest unused ones go first beyond the budget, and the last piece. Trees that were handed out
// live as long as they are held, whatever the budget. All members may be called from any thread;
// one piece is read or built at a time, on all threads of the pool if voxels are read.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/threads/single_flight_cache.h"
#include "src/base/threads/worker_pool.h"
#include "src/index/boxes_file.h"
#include "src/index/index_file.h"
#include "src/index/volume_boxes.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/read_tally.h"

namespace sluice {

using BoxTreePtr = std::shared_ptr<const BoxTree>;

struct BoxStoreCounters {
  int64_t requests = 0, hits = 0;  // trees requested and found; the other trees were decoded
  int64_t pieces_read = 0, pieces_built = 0;   // from the index, from voxels
  uint64_t current_bytes = 0, peak_bytes = 0;  // bytes of the trees that the store keeps
};

class BoxStore {
 public:
  // Fills a region with device voxels for a purpose; called on several threads at once.
  using ReadFor =
      std::function<void(int64_t time, const RegionRead& region, const ReadPurpose& purpose)>;
  // Blocks of one piece of the index.
  static constexpr int64_t kPieceBlocks = 256;

  // `places` are where its index is kept. `budget_bytes` are of trees, `growing_bytes` of voxels
  // while boxes are made of them (forEachBlockBricks). Voxels come through `read` if it is given,
  // which counts them, otherwise from the source. `source`, `ranges` and `pool` must outlive the
  // store.
  BoxStore(VolumeSource& source, IndexPlaces places, int64_t time, const SliceRanges& ranges,
           WorkerPool& pool, uint64_t budget_bytes, uint64_t growing_bytes, ReadFor read = {});

  // The tree of a block. One that is nothing but background is one box, whose gradients are not
  // known: its neighbours' voxels have a part in them. Throws Error from the source and if a
  // block's voxels contradict `ranges`, Interrupted.
  BoxTreePtr tree(int64_t block, const ReadPurpose& purpose = {});
  // The same if no voxel needs to be read for it: null if the index has no boxes yet.
  BoxTreePtr treeIfMade(int64_t block);

  // Counts since the store was made. Any thread.
  BoxStoreCounters counters() const;

 private:
  using Trees = SingleFlightCache<int64_t, const BoxTree>;

  BoxTreePtr treeOf(int64_t block, bool may_build, const ReadPurpose& purpose)
      SLUICE_EXCLUDES(mutex_);
  // Null if it is not in the index and may not be built.
  BoxTreePtr decode(int64_t block, bool may_build, const ReadPurpose& purpose)
      SLUICE_EXCLUDES(mutex_);
  const BoxesPiece* pieceOf(int64_t block, bool may_build, const ReadPurpose& purpose)
      SLUICE_REQUIRES(mutex_);
  std::optional<BoxesPiece> readPiece(int64_t first, int64_t count) const;
  BoxesPiece buildPiece(int64_t first, int64_t count, const ReadPurpose& purpose) const;
  BoxTreePtr backgroundTree(int64_t block) const;

  VolumeSource& source_;
  const IndexPlaces places_;
  const int64_t time_;
  const SliceRanges& ranges_;
  WorkerPool& pool_;
  const uint64_t budget_bytes_, growing_bytes_;
  const ReadFor read_;
  const BoxesOrigin origin_;  // constant after construction
  Trees trees_;
  mutable Mutex mutex_;
  std::optional<BoxesPiece> piece_ SLUICE_GUARDED_BY(mutex_);
  int64_t background_requests_ SLUICE_GUARDED_BY(mutex_) = 0;
  int64_t pieces_read_ SLUICE_GUARDED_BY(mutex_) = 0, pieces_built_ SLUICE_GUARDED_BY(mutex_) = 0;
};

// Keeps trees in the index as they come by, for a pass over all blocks that is made anyway: piece
// by piece, each as soon as all its blocks that are not background are there.
class BoxIndexWriter {
 public:
  // Takes the same arguments as a BoxStore, which finds the trees written here.
  BoxIndexWriter(const VolumeSource& source, IndexPlaces places, int64_t time,
                 const SliceRanges& ranges);

  // To be called once for each block, from any thread. Requires: the tree was made with
  // growingParameters() for the ranges, from bricks of kGrowingBrickSide.
  void add(int64_t block, const BoxTree& tree);

  // Pieces that were stored in some folder.
  int64_t piecesWritten() const;

 private:
  struct Pending {
    std::vector<std::vector<std::byte>> trees;
    int64_t missing = 0;
  };

  const VolumeSource& source_;
  const IndexPlaces places_;
  const int64_t time_;
  const SliceRanges& ranges_;
  const BoxesOrigin origin_;  // constant after construction
  mutable Mutex mutex_;
  std::unordered_map<int64_t, Pending> pending_ SLUICE_GUARDED_BY(mutex_);  // by the first block
  int64_t pieces_written_ SLUICE_GUARDED_BY(mutex_) = 0;
};

}  // namespace sluice
