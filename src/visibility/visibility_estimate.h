// VisibilityEstimate: which blocks of a time step a view can see at all, from their opacity
// functions alone, before any block is read (Gao 2004, section 6).
//
// Blocks are visited front to back against an opacity buffer that has a value for each ray of the
// picture. A block is hidden where all rays that meet it are opaque when they do; otherwise what
// its function says of its thickness along each ray is added. The buffer is split in tiles, which
// are independent of each other: threads take one each, and so may ranks.
//
// From one step to another only tiles are looked at in which a block was reached whose function
// changes; the tree of coherent spans (toc_tree.h) finds those blocks. Tiles that stay keep their
// answer, so that the answer is the same as that of a new estimate.
//
// What is added is no more than what the picture accumulates there. Its samples lie at the view's
// slices, so that a stretch of d slices has d - 1 samples at the least, and one of extinction k
// behind another of at least k has as many as both have together: a slice is taken off for each
// rise along the ray. One thread calls; the pool's threads work inside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/worker_pool.h"
#include "src/device/frame_values.h"
#include "src/visibility/series_opacity.h"

namespace sluice {

// Rays and what else of a view the estimate needs, as devices have it.
struct EstimateView {
  PictureSize size;
  RayGrid rays;
  std::array<std::array<double, 4>, 3> clip_from_index{};  // see FrameSetup
  bool parallel = true;
  Vec3d eye;  // index space: the direction of a parallel view, otherwise the eye
  double first_slice = 0, depth_step = 1, slice_length = 1;  // see FrameSetup
  std::array<double, 2> tan_half{};                          // perspective: of its tan_half_x, _y
};
EstimateView estimateView(const FrameSetup& setup, Vec3d eye_or_direction);

// What is taken for the opacity of a block (opacity_function.h).
enum class OpacityForm {
  kPof,         // one opacity for all rays that cross enough of it
  kLinearOpof,  // in proportion to the thickness: the paper's
  kOpof,        // 1 - exp(-extinction * thickness), and its parts one by one
};

struct EstimateOptions {
  OpacityForm form = OpacityForm::kOpof;
  double opacity_threshold = 0.95;     // from this opacity on a ray is opaque
  std::vector<Box3> shown = {};        // cells that may show; empty: all. One at most
  std::vector<ClipPlane> clip_planes;  // of the picture
  double exponent = 1;                 // of 1 - opacity (equation 4, a basis of one function)
  // Looks at tiles first_tile, first_tile + tile_stride, ... alone: of several that share the
  // picture, each says what is reached in its tiles.
  int tile_stride = 1, first_tile = 0;
};

class VisibilityEstimate {
 public:
  static constexpr int kTileSide = 16;  // pixels

  VisibilityEstimate(SeriesOpacityPtr series, const EstimateView& view,
                     const EstimateOptions& options);

  // Makes the answer that of a step. `from_scratch`: looks at all tiles, as without coherence.
  // Requires: 0 <= step < the series' steps.
  void setStep(int64_t step, WorkerPool& pool, bool from_scratch = false);

  // Whether a ray that is not opaque meets the block, empty ones too. By id.
  bool reaches(int64_t block) const { return reached_in_[static_cast<size_t>(block)] > 0; }
  int64_t step() const { return step_; }
  // Of the last setStep().
  int64_t pixelsChecked() const { return pixels_checked_; }
  int64_t changedBlocks() const { return changed_blocks_; }
  // Of a new estimate.
  int64_t allPixels() const { return all_pixels_; }

 private:
  struct Rect {
    int x0, y0, x1, y1;  // half-open
  };
  struct Tile {
    Rect pixels;
    std::vector<uint32_t> blocks;  // whose footprints may reach into it, front to back
    std::vector<bool> reached;     // of these
  };
  // What does not change from step to step.
  struct Place {
    Rect footprint;               // pixels; bounds
    uint32_t rank = 0;            // in the visit
    std::vector<int> directions;  // cells of its function's table
    float least_slices = 0;       // of the table's ratio
    bool whole = true;            // all of it may show, in front of the eye
    bool has_ratio = true;        // samples are close enough for it
  };
  class TileWork;

  void placeBlocks();
  void placeDirections(int64_t block, Place& place) const;
  void makeTiles();
  Rect footprintOf(const Box3& cells) const;
  bool isShown(const Box3& cells) const;
  std::vector<int64_t> axisOrder(int axis, int64_t first, int64_t count, int64_t side,
                                 int64_t offset) const;
  Box3 changedCells(int64_t block, int32_t before, int32_t now) const;
  std::vector<size_t> affectedTiles(int64_t step) const;
  void estimateTile(Tile& tile) const;
  float ratioOf(const OpacityFunction& function, const Place& place) const;

  const SeriesOpacityPtr series_;
  const EstimateView view_;
  const EstimateOptions options_;
  const float limit_;  // extinction times slices of an opaque ray
  std::array<float, 256> extinction_{};
  // Of pixel coordinates x and y; perspective: times w, and from the picture's middle.
  std::array<std::array<double, 4>, 2> pixel_from_index_{};
  int tiles_x_ = 0, tiles_y_ = 0;
  std::vector<Place> places_;
  std::vector<uint32_t> order_;  // block ids, front to back
  std::vector<Tile> tiles_;
  std::vector<int32_t> reached_in_;  // tiles, of each block
  std::vector<int32_t> functions_;   // of the step
  int64_t step_ = -1;
  int64_t pixels_checked_ = 0, changed_blocks_ = 0, all_pixels_ = 0;
};

}  // namespace sluice
