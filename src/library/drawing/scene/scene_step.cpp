// The distance between slices of a scene's pictures for which nobody sets one.
#include <algorithm>
#include <cmath>
#include <memory>

#include "src/base/values/tidy_number.h"
#include "src/library/drawing/scene/scene.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "src/render/session/planner.h"

namespace sluice {
namespace {

// The finest level in the picture of a layer.
int finestLevelOf(const Scene& scene, const Layer& layer, const TimeStep& step, const View& view,
                  const FrameOptions& options) {
  const TransferFunction& transfer = layer.look.transfer;
  if (!drawsCut(step, options.cut, options.mode, transfer)) return 0;
  if (!options.cut->keeps_thin) return finestLevelShown(step, view, *options.cut);
  // Thin parts may be refined anywhere, which the cut alone tells.
  ChunkNames names;
  Planner planner(layer.page, scene.pool, names);
  const LookPtr look =
      planner.look(step, std::make_shared<const TransferFunction>(transfer), options.mode);
  const VisibleBlocksPtr blocks =
      planner.visibleBlocks(Planner::question(step, look, view, options));
  return finestLevelDrawn(*blocks);
}

// stepFor() of a picture whose finest level is this one.
double stepAtLevel(const View& view, const TimeStep& step, int finest_level) {
  VolumeLayout level = step.source->layout();
  const double times = spacingOfLevel(step, finest_level);
  // The level as if it were a volume of its own.
  level.spacing = level.spacing * times;
  for (int a = 0; a < 3; ++a)
    level.dims[a] = std::max<int64_t>(1, std::llround(static_cast<double>(level.dims[a]) / times));
  return tidyNumber(times * stepFor(view, level));
}

// The distance between slices of a layer for which nobody sets one.
double chosenStepOf(const Scene& scene, const Layer& layer, const TimeStep& step, const View& view,
                    const FrameOptions& options) {
  // One plane is drawn a finest voxel thick at any level: wider steps would pass it.
  const int level = planesOf(options.crop, step.source->layout().dims) != VoxelPlanes()
                        ? 0
                        : finestLevelOf(scene, layer, step, view, options);
  // At the edge of a body, light changes faster from slice to slice than values do, which shows as
  // rings. Frames of a moving picture that shows coarser levels have no time for more slices.
  constexpr double kLitFactor = 0.5;
  const bool is_finer = layer.look.lit && (level == 0 || !options.time_limit_s);
  const double chosen = stepAtLevel(view, step, level) * (is_finer ? kLitFactor : 1);
  if (!options.integrates || drawsCut(step, options.cut, options.mode, layer.look.transfer))
    return chosen;
  // As long as frames may integrate.
  const double most =
      options.step_vox * kMostIntegratedStep / longestStep(view, layer.volume.source->layout());
  return std::min(chosen * options.step_factor, most);
}

}  // namespace

double stepFor(const View& view, const VolumeLayout& layout) {
  double pixel = 2 * view.half_height / view.size.height;
  if (view.projection == Projection::kPerspective) {
    const Vec3d center = worldFromIndex(layout, toDouble(layout.dims - Vec3i{1, 1, 1}) * 0.5);
    pixel *= std::max(0.0, dot(center - view.eye, view.forward));
  }
  // If a voxel covers more than a pixel, the picture shows the slices in it.
  return pixel < finestSpacing(layout) ? 0.5 : 1;
}

std::vector<TimeStep> Scene::openedSteps() const {
  std::vector<TimeStep> steps;
  for (const Layer* layer : layers()) steps.push_back(layer->volume.step());
  return steps;
}

double Scene::chosenStep(const std::vector<TimeStep>& steps, const FrameOptions& options) const {
  if (!traitsOf(options.mode).has_colors) return options.step_vox;
  const VolumeLayout& first = volume.source->layout();
  const View view = resolve(options, first);
  double least = chosenStepOf(*this, *this, steps.front(), view, optionsOf(*this, options));
  for (size_t i = 0; i < more.size(); ++i) {
    const auto& layer = more[i];
    const VolumeLayout& layout = layer->volume.source->layout();
    const FrameOptions own = optionsOf(*layer, options);
    const View own_view = resolve(own, layout);
    const double own_step = chosenStepOf(*this, *layer, steps[i + 1], own_view, own);
    // One distance for all layers: the finest one that any of them needs, in the first volume's
    // voxels.
    least = std::min(least, stepOn(first, layout, own_step));
  }
  return least;
}

}  // namespace sluice
