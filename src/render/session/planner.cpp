#include "src/render/session/planner.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"

namespace sluice {

LookPtr Planner::look(const TimeStep& step, const TransferPtr& transfer, Mode mode) {
  return look_.of({step, transfer, mode}, [&] { return makeLook(step, *transfer, mode); });
}

bool Planner::integrates(const TimeStep& step, const Look& look, const View& view,
                         const FrameOptions& options) {
  return options.integrates && traitsOf(options.mode).has_colors && !look.table.labels() &&
         look.table.surfaces().empty() && step.ranges->layout.ghost > 0 &&
         !drawsCut(step, options.cut, options.mode, look.transfer) &&
         stepsIntegrate(view, step.source->layout());
}

bool Planner::drawsSurfaces(const TimeStep& step, const Look& look, const FrameOptions& options) {
  if (look.table.surfaces().empty() || !traitsOf(options.mode).has_colors) return false;
  // Normals at surfaces are taken from voxels beside the cells.
  SLUICE_CHECK(step.ranges->layout.ghost > 0);
  return true;
}

double Planner::stepForSurfaces(const View& view, const VolumeLayout& layout, double step_vox,
                                Vec3d voxel) {
  const Vec3d spacing = layout.spacing * voxel;
  const double finest = std::min({spacing.x, spacing.y, spacing.z}) / finestSpacing(layout);
  return std::min(
      {step_vox, step_vox / longestStep(view, layout, voxel), kMostSurfaceStep * finest});
}

BlockQuestion Planner::question(const TimeStep& step, const LookPtr& look, const View& view,
                                const FrameOptions& options, const ReadLimit* limit) {
  std::optional<CutOptions> cut;
  if (drawsCut(step, options.cut, options.mode, look->transfer)) cut = options.cut;
  return {step,
          look,
          cropCells(options, step.ranges->layout.dims),
          view,
          cut,
          limit,
          integrates(step, *look, view, options) || drawsSurfaces(step, *look, options),
          options.algorithm};
}

BlockChooser& Planner::chooserFor(const BlockQuestion& question) {
  if (chooser_ != nullptr) return *chooser_;
  if (question.cut) return cut_;
  return classified_;
}

std::vector<VisibleBlocksPtr> Planner::visibleTogether(std::span<Planner* const> planners,
                                                       std::span<const BlockQuestion> questions) {
  std::vector<BlockChooser*> choosers;
  std::vector<LevelCut*> cuts;
  for (size_t i = 0; i < planners.size(); ++i) {
    choosers.push_back(&planners[i]->chooserFor(questions[i]));
    cuts.push_back(choosers[i]->cutFor(questions[i]));
  }
  std::vector<VisibleBlocksPtr> visible;
  // A volume that is no cut cannot be refined together with the others.
  if (std::ranges::count(cuts, nullptr) > 0) {
    for (size_t i = 0; i < choosers.size(); ++i)
      visible.push_back(choosers[i]->choose(questions[i]));
    return visible;
  }
  visible = LevelCut::chooseTogether(cuts, questions);
  // The choosers may leave out blocks of the cut that others hide. They judge by the coarsest level
  // that any of the volumes shows.
  int coarsest = 0;
  for (size_t i = 0; i < visible.size(); ++i)
    coarsest =
        std::max(coarsest, coarsestLevelShown(questions[i].step, questions[i].view, *visible[i]));
  for (size_t i = 0; i < visible.size(); ++i)
    visible[i] = choosers[i]->chooseOf(questions[i], visible[i], coarsest);
  return visible;
}

FramePlanPtr Planner::plan(const TimeStep& step, const VisibleBlocksPtr& visible,
                           const FrameOptions& options, const TexturePlanPtr& clusters) {
  // The clusters are part of the key, as a plan of one medium has the clusters of all channels.
  const Box3 crop = cropCells(options, step.ranges->layout.dims);
  const VoxelPlanes planes = planesOf(options.crop, step.ranges->layout.dims);
  return plan_.of(
      {step, visible, options.algorithm, options.merge_order, crop, planes, clusters}, [&] {
        return makeFramePlan(
            step, *visible, page_,
            {options.algorithm, options.merge_order, step.time, crop, clusters.get(), planes},
            names_);
      });
}

FramePlanPtr Planner::planFor(const TimeStep& step, const TransferPtr& transfer,
                              const FrameOptions& options) {
  const View view = resolve(options, step.source->layout());
  const LookPtr shown = look(step, transfer, options.mode);
  return plan(step, visibleBlocks(question(step, shown, view, options)), options);
}

DrawOrderPtr Planner::order(const FramePlanPtr& plan, const EyePosition& eye,
                            Arrangement arrangement) {
  return order_.of({plan, eye.parallel, eye.index, arrangement},
                   [&] { return makeDrawOrder(plan->textures, eye, arrangement); });
}

}  // namespace sluice
