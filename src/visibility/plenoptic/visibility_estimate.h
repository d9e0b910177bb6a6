// VisibilityEstimate: which blocks of a time step a view can see at all, from their opacity
// functions alone, before any block is read (Gao 2004, section 6).
//
// Blocks are visited front to back against an opacity buffer that has a value for each ray of the
// picture. A block is hidden if all rays that meet it are opaque when they do; otherwise its
// function's extinction for its thickness is added along each ray. The buffer is split in tiles,
// which are independent of each other: threads take one each, and so may ranks.
//
// From one step to another only tiles are looked at in which a block was reached whose function
// changes, from that block on; the tree of coherent spans (toc_tree.h) finds those blocks. A tile
// keeps the sums that each block it reached adds along each ray, so that blocks that stay as they
// are need no new computation: the answer equals a new estimate's, bit for bit.
//
// A block never adds more than the picture accumulates there. The estimate's samples lie at the
// view's slices, and each hides at least as much as the part of the block that it is in. Rounding
// may put a sample on either side of a face between two parts. Its value is then that of the face,
// which both parts contain, but for less than an entry of the opacity table, and the parts allow
// for that (extinction.h). One thread calls; the pool's threads work inside.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/threads/worker_pool.h"
#include "src/device/frame_values.h"
#include "src/visibility/plenoptic/series_opacity.h"
#include "src/visibility/plenoptic/unpacked_parts.h"

namespace sluice {

// Rays and other values of a view that the estimate needs, as devices have them.
struct EstimateView {
  PictureSize size;
  RayGrid rays;
  std::array<std::array<double, 4>, 3> clip_from_index{};  // see FrameSetup
  bool parallel = true;
  Vec3d eye;  // index space: the direction of a parallel view, otherwise the eye
  double first_slice = 0, depth_step = 1, slice_length = 1;  // see FrameSetup
  std::array<double, 2> tan_half{};                          // perspective: of its tan_half_x, _y
};
// `eye_or_direction`: see EstimateView::eye.
EstimateView estimateView(const FrameSetup& setup, Vec3d eye_or_direction);

// The form in which a block's opacity is estimated (opacity_function.h).
enum class OpacityForm {
  kPof,         // one opacity for all rays that cross enough of it
  kLinearOpof,  // in proportion to the thickness: the paper's
  kOpof,        // 1 - exp(-extinction * thickness), and its parts one by one
};

struct EstimateOptions {
  OpacityForm form = OpacityForm::kOpof;
  double opacity_threshold = 0.95;     // from this opacity on a ray is opaque
  std::vector<Box3> shown = {};        // cells that may show, at most one box; empty: all
  std::vector<ClipPlane> clip_planes;  // the picture's clip planes
  double exponent = 1;  // applied to 1 - opacity (equation 4, a basis of one function)
  // Looks only at tiles first_tile, first_tile + tile_stride, ...: each of several processes that
  // share the picture tells which blocks are reached in its tiles.
  int tile_stride = 1, first_tile = 0;
  // Limit for the sums of blocks that tiles keep, see the top. 0 if no step follows.
  // Another eighth of it may list the parts of blocks that change; with more, whole blocks are
  // listed.
  uint64_t most_kept_bytes = uint64_t{256} << 20;
};

class VisibilityEstimate {
 public:
  static constexpr int kTileSide = 16;  // pixels

  VisibilityEstimate(SeriesOpacityPtr series, const EstimateView& view,
                     const EstimateOptions& options);

  // The most bytes that an estimate for a picture of this size takes in addition to the series:
  // places of blocks, tiles, what tiles keep, and what threads unpack. Views that are much closer
  // than one that the volume fills have longer lists of blocks, which are not counted.
  static uint64_t mostBytes(const SeriesOpacity& series, PictureSize size, uint64_t most_kept_bytes,
                            int threads);

  // Brings the answer to a step. `from_scratch`: looks at all tiles, as without coherence.
  // Requires: 0 <= step < the series' steps. After an exception the next call starts from scratch.
  void setStep(int64_t step, WorkerPool& pool, bool from_scratch = false);

  // Whether a ray that is not opaque meets the block, empty ones too. Blocks are given by id.
  bool reaches(int64_t block) const { return reached_in_[static_cast<size_t>(block)] > 0; }
  // Work of the last setStep().
  int64_t pixelsChecked() const { return pixels_checked_; }
  int64_t changedBlocks() const { return changed_blocks_; }
  // Work of a new estimate.
  int64_t allPixels() const { return all_pixels_; }

 private:
  struct Rect {
    int x0, y0, x1, y1;  // half-open
  };
  using TilePixels = std::array<float, static_cast<size_t>(kTileSide) * kTileSide>;
  // The sum that a block adds along the rays of a tile, row after row. A minus sign marks a lower
  // bound: the ray was opaque at slice `end` and not followed further.
  struct Added {
    int32_t function = -1;  // the block's function
    TilePixels along, end;
    std::array<int32_t, static_cast<size_t>(kTileSide) * kTileSide>
        clear;  // slices before add nothing
  };
  struct Tile {
    Rect pixels;
    std::vector<uint32_t> blocks;  // blocks whose footprints may reach into the tile, front to back
    std::vector<bool> reached;     // one for each of `blocks`
    std::vector<std::unique_ptr<Added>> added;  // one for each of `blocks`; empty: none is kept
  };
  // A tile to look at.
  struct Task {
    size_t tile = 0;
    std::vector<size_t> changed = {};  // places of blocks that changed; empty: of all
    bool is_affected = true;           // known once it was looked at
  };
  // Something that hides more or less in one step than in the other, and from which slice on.
  struct ChangedPart {
    Rect pixels;
    float near = 0;
  };
  // The last change of steps, for a block.
  struct Change {
    int32_t before = -1;  // function; below 0: none
    std::vector<ChangedPart> parts = {};
  };
  // Values that do not change from step to step.
  struct Place {
    Rect footprint;               // pixels; bounds
    uint32_t rank = 0;            // in the visit
    std::vector<int> directions;  // cells of its function's table
    float least_slices = 0;       // least thickness for the table's ratio
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
  // At most so many, else the whole block.
  std::vector<ChangedPart> changedParts(int64_t block, int32_t before, int32_t now,
                                        size_t most) const;
  float nearSlice(const Box3& cells) const;
  void estimateStep(int64_t step, WorkerPool& pool, bool from_scratch);
  std::vector<Task> allTiles(int64_t step);
  std::vector<Task> affectedTiles(int64_t step, WorkerPool& pool);
  void takeChanges(int64_t step, WorkerPool& pool);
  std::optional<size_t> firstAffected(Task& task);
  void estimateTile(Task& task);
  std::unique_ptr<UnpackedParts> takeUnpacked();
  void giveBack(std::unique_ptr<UnpackedParts> unpacked);
  float ratioOf(const OpacityFunction& function, const Place& place) const;

  const SeriesOpacityPtr series_;
  const EstimateView view_;
  const EstimateOptions options_;
  const float limit_;  // extinction times slices of an opaque ray
  std::array<float, 256> extinction_{};
  // Coefficients of pixel coordinates x and y; perspective: times w, and from the picture's middle.
  std::array<std::array<double, 4>, 2> pixel_from_index_{};
  std::array<double, 4> slice_from_index_{};  // for a parallel view
  int tiles_x_ = 0, tiles_y_ = 0;
  std::vector<Place> places_;
  std::vector<uint32_t> order_;  // block ids, front to back
  std::vector<Tile> tiles_;
  std::vector<int32_t> reached_in_;  // tiles, of each block
  std::vector<int32_t> functions_;   // functions of the current step
  std::vector<Change> changes_;      // one for each block
  std::vector<int64_t> changed_;     // blocks with a change
  Mutex unpacked_mutex_;
  // Work spaces that no thread uses at the moment. Kept from step to step.
  std::vector<std::unique_ptr<UnpackedParts>> unpacked_ SLUICE_GUARDED_BY(unpacked_mutex_);
  int64_t step_ = -1;
  int64_t pixels_checked_ = 0, changed_blocks_ = 0, all_pixels_ = 0;
};

}  // namespace sluice
