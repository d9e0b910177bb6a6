// BoxStore: the boxes of the blocks that are asked for, from the volume's index where they are
// kept, otherwise made from the voxels and kept for the next time.
//
// The index is read and written in pieces of some hundred blocks, so that a frame that sees a
// corner of a volume reads that corner's boxes. In memory are the trees of blocks asked for, the
// longest unused ones go first beyond the budget, and the last piece. Trees that were handed out
// live as long as they are held, whatever the budget. All members may be called from any thread;
// one works at a time, on all threads of the pool where voxels are read.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "src/base/worker_pool.h"
#include "src/classify/boxes_file.h"
#include "src/classify/volume_boxes.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

using BoxTreePtr = std::shared_ptr<const BoxTree>;

struct BoxStoreCounters {
  int64_t requests = 0, hits = 0;              // of trees; the rest was decoded
  int64_t pieces_read = 0, pieces_built = 0;   // from the index, from voxels
  uint64_t current_bytes = 0, peak_bytes = 0;  // of the trees that the store keeps
};

class BoxStore {
 public:
  // Blocks of one piece of the index.
  static constexpr int64_t kPieceBlocks = 256;

  // `volume_name` is what the user called the volume: where its index is kept. `budget_bytes` are
  // of trees, `growing_bytes` of voxels while boxes are made of them (forEachBlockBricks).
  // `source`, `ranges` and `pool` must outlive the store.
  BoxStore(VolumeSource& source, std::string volume_name, int64_t time, const SliceRanges& ranges,
           WorkerPool& pool, uint64_t budget_bytes, uint64_t growing_bytes);

  // The tree of a block. One that is nothing but background is one box, whose gradients are not
  // known: its neighbours' voxels have a part in them. Throws Error from the source, Interrupted.
  BoxTreePtr tree(int64_t block);
  // The same where no voxel needs to be read for it: null where the index has no boxes yet.
  BoxTreePtr treeIfMade(int64_t block);

  BoxStoreCounters counters() const;

 private:
  // All require mutex_ to be held.
  BoxTreePtr treeLocked(int64_t block, bool may_build);
  // Null where it is not in the index and may not be built.
  const BoxesPiece* pieceOf(int64_t block, bool may_build);
  std::optional<BoxesPiece> readPiece(int64_t first, int64_t count) const;
  BoxesPiece buildPiece(int64_t first, int64_t count) const;
  BoxTreePtr backgroundTree(int64_t block) const;
  void keep(int64_t block, const BoxTreePtr& tree);

  VolumeSource& source_;
  const std::string volume_name_;
  const int64_t time_;
  const SliceRanges& ranges_;
  WorkerPool& pool_;
  const uint64_t budget_bytes_, growing_bytes_;
  const BoxesOrigin origin_;  // constant after construction
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::optional<BoxesPiece> piece_;
  std::list<std::pair<int64_t, BoxTreePtr>> recent_;  // most recently used first
  std::unordered_map<int64_t, std::list<std::pair<int64_t, BoxTreePtr>>::iterator> kept_;
  BoxStoreCounters counters_;
};

// Keeps trees in the index as they come by, for a pass over all blocks that is made anyway: piece
// by piece, each as soon as all its blocks that are not background are there.
class BoxIndexWriter {
 public:
  // As for a BoxStore, which finds what is written here.
  BoxIndexWriter(const VolumeSource& source, std::string volume_name, int64_t time,
                 const SliceRanges& ranges);

  // Once for a block, from any thread. Requires: the tree is that of growingParameters() for the
  // ranges, of bricks of kBrickSide.
  void add(int64_t block, const BoxTree& tree);

  // That some folder took.
  int64_t piecesWritten() const;

 private:
  struct Pending {
    std::vector<std::vector<std::byte>> trees;
    int64_t missing = 0;
  };

  const VolumeSource& source_;
  const std::string volume_name_;
  const int64_t time_;
  const SliceRanges& ranges_;
  const BoxesOrigin origin_;  // constant after construction
  mutable std::mutex mutex_;
  std::unordered_map<int64_t, Pending> pending_;  // guarded by mutex_, by the first block
  int64_t pieces_written_ = 0;                    // guarded by mutex_
};

}  // namespace sluice
