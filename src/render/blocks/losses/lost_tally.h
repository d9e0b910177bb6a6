// LostTally: which coarse blocks of a picture lose part of its surfaces, judged as they are read.
//
// The folder: what coarse blocks do not show of the voxels that they stand for. lost_surfaces.h
// judges a block, lost_tally.h and spread_tally.h keep count as blocks are read.
//
// Used on one thread, a session's, but for note(), which any thread may call.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/memo.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

class LostTally {
 public:
  // It notes at most so many blocks, and forgets all when more are read.
  static constexpr size_t kMostBlocks = size_t{1} << 17;

  // Sets the surfaces that are asked for; those of other looks, crops and steps are forgotten.
  // Blocks are judged by judge() alone until expect() is called. The step's ranges are kept.
  void ask(const TimeStep& step, const LookPtr& look, const Box3& crop) SLUICE_EXCLUDES(mutex_);
  // No surfaces are asked for, so that blocks are not judged.
  void askNothing() SLUICE_EXCLUDES(mutex_);
  // Blocks of this picture are judged as they are read. Requires: ask() before.
  void expect(const VisibleBlocksPtr& visible) SLUICE_EXCLUDES(mutex_);
  // A block was just read.
  void note(const BlockName& name, const VolumeBlock& block) SLUICE_EXCLUDES(mutex_);

  // Whether a block was judged and loses something; nullopt: it was not judged.
  std::optional<bool> known(const BlockName& name) const SLUICE_EXCLUDES(mutex_);
  // Judges a block with this object box of a coarser level. Requires: ask() before.
  bool judge(const ObjectBlock& object, const VolumeBlock& block) SLUICE_EXCLUDES(mutex_);

 private:
  struct Key {
    TimeStep step;
    Identity<Look> look;
    Box3 crop;
    friend bool operator==(const Key&, const Key&) = default;
  };
  // Immutable: readers that have begun keep theirs.
  struct Asked {
    Key key;
    PyramidLayout pyramid;
    std::vector<double> values;  // device values
    VisibleBlocksPtr visible;    // null before expect()
  };
  using AskedPtr = std::shared_ptr<const Asked>;

  static bool loses(const Asked& asked, const ObjectBlock& object, const VolumeBlock& block);
  void store(const AskedPtr& asked, const BlockName& name, bool is_lost) SLUICE_EXCLUDES(mutex_);
  AskedPtr asked() const SLUICE_EXCLUDES(mutex_);

  mutable Mutex mutex_;
  AskedPtr asked_ SLUICE_GUARDED_BY(mutex_);  // null: nothing is asked for
  std::unordered_map<BlockName, bool, BlockNameHash> is_lost_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
