// CulledBlocks: the blocks of a time step that its picture can see, from the opacity functions of
// the series (Gao 2004, section 6). Another source of visible blocks: later stages of a frame's
// chain do not know of it, and nothing of a hidden block is read.
//
// The answer to the last question is kept. For another step of the same view, only the tiles that a
// changed block can affect are estimated again. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/frame_options.h"
#include "src/visibility/plenoptic/visibility_estimate.h"

namespace sluice {

struct CullingOptions {
  OpacityForm form = OpacityForm::kOpof;
  double opacity_threshold = kDefaultOpaque;
  bool uses_coherence = true;  // the tree; without it every step is looked at as a whole
  std::vector<WorldPlane> clip_planes = {};
  double exponent = 1;                                           // see EstimateOptions
  uint64_t most_kept_bytes = EstimateOptions().most_kept_bytes;  // with coherence
  // If several processes work on a picture together, each has its tiles, see EstimateOptions.
  // `exchange` turns the blocks that one process found to be reached at a step into those that all
  // found.
  int tile_stride = 1, first_tile = 0;
  std::function<void(int64_t time, std::vector<bool>& reached)> exchange = {};
};

// Work and result of the last choice.
struct CullingCounts {
  int64_t time = -1;  // step
  int64_t blocks_nonempty = 0, blocks_visible = 0;
  int64_t pixels_checked = 0, pixels = 0;
  int64_t changed_blocks = 0;
  double estimate_seconds = 0;
};

class CulledBlocks : public BlockChooser {
 public:
  // `pool` must outlive it. Requires: the functions are of the volume's series, in its blocks.
  CulledBlocks(SeriesOpacityPtr series, const VolumeLayout& layout, const CullingOptions& options,
               WorkerPool& pool);

  // The most bytes that it takes in addition to the functions' own data, on so many threads.
  static uint64_t mostBytes(const SeriesOpacity& series, PictureSize size,
                            const CullingOptions& options, int threads);

  VisibleBlocksPtr choose(const BlockQuestion& question) override;
  const CullingCounts& counts() const { return counts_; }
  // The counts of a step: the last one that was chosen for, or the one before it, since a frame may
  // choose for the next step too. Requires: `time` is one of them.
  const CullingCounts& countsOf(int64_t time) const;

 private:
  struct Asked {
    Identity<VisibleBlocks> classified;
    View view;
    Box3 crop;
    int64_t time;
  };

  const SeriesOpacityPtr series_;
  const VolumeLayout layout_;
  const CullingOptions options_;
  WorkerPool& pool_;
  ClassifiedBlocks classified_;
  std::optional<VisibilityEstimate> estimate_;
  std::optional<Asked> asked_;
  VisibleBlocksPtr answer_;
  CullingCounts counts_, before_;
};

// The view in the form that the estimate needs.
EstimateView estimateView(const View& view, const VolumeLayout& layout);

}  // namespace sluice
