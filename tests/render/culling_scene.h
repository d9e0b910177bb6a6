// A scene of bytes or floats whose culling is held against every sample of every ray.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "src/render/blocks/culled_blocks.h"
#include "src/render/camera/index_space.h"
#include "src/visibility/occlusion/early_termination.h"
#include "tests/render/render_scene.h"
#include "tests/support/memory_source.h"
#include "tests/support/series_functions.h"

namespace sluice {

struct CullingScene {
  CullingScene(MemorySource& volume, const TransferFunction& transfer, int64_t block,
               int64_t time = 0)
      : source(volume),
        pool(2),
        ranges(std::make_shared<const SliceRanges>(buildSliceRanges(
            source, time, blockLayout(source.layout().dims, block, 0), {pool, progress}))),
        step{&source, time, ranges},
        look(std::make_shared<const Look>(makeLook(step, transfer, Mode::kComposite))) {}

  View view(const FrameOptions& options) const { return resolve(options, source.layout()); }
  BlockQuestion question(const FrameOptions& options) const {
    return {step, look, cropCells(options, source.layout().dims), view(options)};
  }
  std::vector<bool> reached(const FrameOptions& options, double threshold) {
    const bool is_float = source.layout().type == VoxelType::kF32;
    const size_t bytes =
        static_cast<size_t>(volume(source.layout().dims)) * (is_float ? sizeof(float) : 1);
    return reachedByRays({source.layout().dims, is_float ? DeviceType::kF32 : DeviceType::kU8,
                          source.bytes().subspan(static_cast<size_t>(step.time) * bytes, bytes)},
                         ranges->layout.cells(), look->table,
                         estimateView(view(options), source.layout()), threshold, pool);
  }

  MemorySource& source;
  WorkerPool pool;
  ProgressMeter progress;
  std::shared_ptr<const SliceRanges> ranges;
  TimeStep step;
  LookPtr look;
};

inline FrameOptions randomView(std::mt19937& random, const VolumeLayout& layout) {
  std::uniform_real_distribution<double> unit(0, 1);
  FrameOptions options;
  options.camera.projection = random() % 2 == 0 ? Projection::kOrtho : Projection::kPerspective;
  options.camera.azimuth_deg = random() % 8 == 0 ? 90.0 * (random() % 4) : 360 * unit(random);
  options.camera.elevation_deg = random() % 8 == 0 ? 0 : 170 * unit(random) - 85;
  options.camera.zoom = 0.7 + 2 * unit(random);
  options.step_vox = random() % 3 == 0 ? 1 : 0.3 + unit(random);
  if (random() % 6 == 0) {
    const auto place = [&] { return Vec3d{unit(random), unit(random), unit(random)}; };
    const auto inside = insideView(layout, place() * 1.5 - Vec3d{0.25, 0.25, 0.25}, place());
    options.camera = inside.camera;
  }
  options.size = {40 + static_cast<int>(random() % 60), 40 + static_cast<int>(random() % 60)};
  return options;
}

struct ReachedCounts {
  int64_t reached = 0, visible = 0, nonempty = 0;  // blocks, of the tightest form
};

// No block that rays reach before `threshold` is missing, whatever the form; a tighter one sees no
// more.
inline void expectNothingReachedIsCulled(CullingScene& scene, const TestSeries& series,
                                         const FrameOptions& options, double threshold,
                                         ReachedCounts& counts) {
  const std::vector<bool> truth = scene.reached(options, threshold);
  const StepBlocks& blocks = series.steps[static_cast<size_t>(scene.step.time)];
  size_t last_count = 0;
  for (const OpacityForm form : {OpacityForm::kOpof, OpacityForm::kLinearOpof, OpacityForm::kPof}) {
    CulledBlocks culled(series.opacity, scene.source.layout(), {form, threshold}, scene.pool);
    const VisibleBlocksPtr found = culled.choose(scene.question(options));
    std::vector<bool> is_visible(truth.size(), false);
    for (const ObjectBlock& each : found->blocks)
      is_visible[static_cast<size_t>(each.name.block)] = true;
    int64_t seen = 0;
    for (size_t b = 0; b < truth.size(); ++b) {
      if (!truth[b] || blocks.isEmpty(static_cast<int64_t>(b))) continue;
      ++seen;
      EXPECT_TRUE(is_visible[b]) << "block " << b;
    }
    EXPECT_GE(found->blocks.size(), last_count) << "a tighter form sees no more";
    last_count = found->blocks.size();
    if (form != OpacityForm::kOpof) continue;
    counts.reached += seen;
    counts.visible += static_cast<int64_t>(found->blocks.size());
    counts.nonempty += culled.counts().blocks_nonempty;
  }
}

}  // namespace sluice
