// BlockChooser decides which blocks of a time step a picture needs, the third arrow of a frame's
// chain. Later stages do not know how they were chosen.
//
// By default that is the classification: blocks in which something is not transparent. An estimate
// of which blocks are hidden, or a cut through levels of resolution, is another chooser.
//
// The folder: here, the first values of a frame's chain (time_step.h, look.h) and the choosers.
// cut/ has the cut through levels of resolution, and losses/ what the coarse blocks of a picture do
// not show.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "src/base/threads/worker_pool.h"
#include "src/classify/blocks/classification.h"
#include "src/render/blocks/cut/read_limit.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/memo.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/cut_options.h"
#include "src/texture/texture_plan.h"

namespace sluice {

struct BlockQuestion {
  TimeStep step;
  LookPtr look;
  Box3 crop;  // cells that may show
  View view;
  std::optional<CutOptions> cut = {};        // unset: the finest level alone
  const ReadLimit* limit = nullptr;          // of a cut; null: it waits for all data
  bool looks_around = false;                 // the frame integrates or has surfaces; not of a cut
  Algorithm algorithm = Algorithm::kMerged;  // whether blocks that are not visible are loaded, too
  // Tells, of a cut that keeps what is thin, whether the voxels of a coarser block lose part of a
  // surface. It may read the block. Null: that is not known.
  std::function<bool(const ObjectBlock&)> loses_surface = {};
};

class LevelCut;

class BlockChooser {
 public:
  virtual ~BlockChooser() = default;
  // Blocks of the step's layout, of this or of other time steps and of any level, ascending by
  // name; each finest cell at most once. Returns the same object again if no input has changed:
  // then the values that follow from it are kept too.
  virtual VisibleBlocksPtr choose(const BlockQuestion& question) = 0;
  // The cut that it takes the blocks from, of which several volumes may be (see
  // LevelCut::chooseTogether()); null: it makes none.
  virtual LevelCut* cutFor(const BlockQuestion& /*question*/) { return nullptr; }
  // Its blocks among those of that cut, which shows the picture's coarsest level somewhere, in this
  // volume or another.
  virtual VisibleBlocksPtr chooseOf(const BlockQuestion& /*question*/,
                                    const VisibleBlocksPtr& of_cut, int /*coarsest_level*/) {
    return of_cut;
  }
};

// classify(), or classifyAround() for a frame that looks around its samples, kept while its inputs
// stay.
class ClassifiedBlocks : public BlockChooser {
 public:
  explicit ClassifiedBlocks(WorkerPool& pool) : pool_(pool) {}
  VisibleBlocksPtr choose(const BlockQuestion& question) override;

 private:
  struct Key {
    TimeStep step;
    Identity<Look> look;
    Box3 crop;
    bool looks_around;
    friend bool operator==(const Key&, const Key&) = default;
  };
  WorkerPool& pool_;
  Memo<Key, const VisibleBlocks> memo_;
};

}  // namespace sluice
