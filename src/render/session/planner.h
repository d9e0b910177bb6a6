// Planner: the front half of a frame's chain, the same for pictures, `sluice plan` and the
// simulator: from a time step to the order of its visit.
//
//   TimeStep -> Look -> VisibleBlocks -> FramePlan -> DrawOrder
//
// Each is a pure function of the values to its left and of options, and each value is kept until
// its inputs change. No voxel is touched and no device is used. One thread; classification runs on
// all threads of the pool.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cache/model/page_geometry.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/blocks/cut/level_cut.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/frame_options.h"
#include "src/render/frame/draw_order.h"
#include "src/render/frame/frame_plan.h"

namespace sluice {

using TransferPtr = std::shared_ptr<const TransferFunction>;

// The unit is the finest spacing of the finest level that is drawn.
inline constexpr double kMostSurfaceStep = 1;

class Planner {
 public:
  // `pool` and `names` must outlive it.
  Planner(const PageGeometry& page, WorkerPool& pool, ChunkNames& names)
      : page_(page), names_(names), classified_(pool), cut_(pool) {}

  // Blocks are chosen by this from now on, which must outlive its use; null: by a cut if
  // the picture is drawn from one (drawsCut()), else by classification.
  void chooseBlocksBy(BlockChooser* chooser) { chooser_ = chooser; }

  // The look of a step. The last one is kept and returned again for the same arguments.
  LookPtr look(const TimeStep& step, const TransferPtr& transfer, Mode mode);
  // Whether visibleBlocks() makes a cut through the levels of resolution itself.
  bool makesCut(const TimeStep& step, const LookPtr& look, const FrameOptions& options) const {
    return chooser_ == nullptr && drawsCut(step, options.cut, options.mode, look->transfer);
  }
  // Whether a frame is pre-integrated: its options ask for it, and it can be. It cannot in modes
  // without colours, of labels, of a cut, without a ghost layer, or if slices are more than two
  // voxels apart on an axis.
  static bool integrates(const TimeStep& step, const Look& look, const View& view,
                         const FrameOptions& options);
  // Whether a frame draws surfaces: its look has some, and its mode colours. Such a frame does not
  // integrate. Requires: blocks have a ghost layer.
  static bool drawsSurfaces(const TimeStep& step, const Look& look, const FrameOptions& options);
  // The distance between slices of frames with surfaces: at most a voxel along any axis, see
  // FrameSetup, and kMostSurfaceStep. Between slices farther apart, rays enter and leave the rims
  // of bodies unseen, and spots of what lies behind show there. `voxel`: the voxels of the finest
  // level that is drawn, in units of the volume's voxels along each axis.
  static double stepForSurfaces(const View& view, const VolumeLayout& layout, double step_vox,
                                Vec3d voxel = {1, 1, 1});
  // The chooser's answer. The question's `limit` and `loses_surface` apply to such a cut alone.
  VisibleBlocksPtr visibleBlocks(const BlockQuestion& question) {
    return chooserFor(question).choose(question);
  }
  // The question for visibleBlocks(), without `loses_surface`. `limit` must outlive it.
  static BlockQuestion question(const TimeStep& step, const LookPtr& look, const View& view,
                                const FrameOptions& options, const ReadLimit* limit = nullptr);
  // The answers of several planners' choosers to a question each. If all of them make a cut, it is
  // one cut.
  static std::vector<VisibleBlocksPtr> visibleTogether(std::span<Planner* const> planners,
                                                       std::span<const BlockQuestion> questions);
  // `clusters`: PlanOptions::clusters. Throws Error when the texture cache has fewer pages than one
  // block.
  FramePlanPtr plan(const TimeStep& step, const VisibleBlocksPtr& visible,
                    const FrameOptions& options, const TexturePlanPtr& clusters = nullptr);
  // The three in a row.
  FramePlanPtr planFor(const TimeStep& step, const TransferPtr& transfer,
                       const FrameOptions& options);
  DrawOrderPtr order(const FramePlanPtr& plan, const EyePosition& eye, Arrangement arrangement);

 private:
  struct LookKey {
    TimeStep step;
    Identity<TransferFunction> transfer;
    Mode mode;
    friend bool operator==(const LookKey&, const LookKey&) = default;
  };
  struct PlanKey {
    TimeStep step;
    Identity<VisibleBlocks> visible;
    Algorithm algorithm;
    MergeOrder merge_order;
    Box3 crop;
    VoxelPlanes planes;
    Identity<TexturePlan> clusters;
    friend bool operator==(const PlanKey&, const PlanKey&) = default;
  };
  struct OrderKey {
    Identity<FramePlan> plan;
    bool parallel;
    Vec3d eye;
    Arrangement arrangement;
    friend bool operator==(const OrderKey&, const OrderKey&) = default;
  };

  BlockChooser& chooserFor(const BlockQuestion& question);

  const PageGeometry page_;
  ChunkNames& names_;
  BlockChooser* chooser_ = nullptr;
  ClassifiedBlocks classified_;
  LevelCut cut_;
  Memo<LookKey, const Look> look_;
  Memo<PlanKey, const FramePlan> plan_;
  Memo<OrderKey, const DrawOrder> order_;
};

}  // namespace sluice
