// Volumes with levels of resolution for tests of cuts: pyramids of means, the blocks that a planner
// chooses of them, and their pictures.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <utility>

#include "io/synth/mean_levels.h"
#include "src/render/session/planner.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice {

inline constexpr int64_t kBlock = 16;

// A source with levels of means above it; without spreads each level has ranges of its own.
struct Pyramid {
  Pyramid(VolumeSource& finest, int64_t count, bool lit = false, Spreads spreads = Spreads::kNone,
          int64_t block = kBlock)
      : source(finest), means(finest, count, spreads), pool(2) {
    PyramidLayout layout(blockLayout(finest.layout().dims, block, lit ? 2 : 1));
    step.source = &finest;
    step.ranges = rangesOf(finest, layout.finest());
    for (const CoarserLevel& level : means.levels()) {
      const bool has_spreads = level.spreads != nullptr;
      EXPECT_EQ(layout.add(level.source->layout().dims, level.placement, has_spreads ? 2 : 1), "");
      const BlockLayout& blocks = layout.level(layout.levels() - 1).blocks;
      step.coarser.push_back(
          {level.source, has_spreads ? nullptr : rangesOf(*level.source, blocks), level.spreads});
    }
    step.pyramid = std::make_shared<const PyramidLayout>(layout);
  }
  std::shared_ptr<const SliceRanges> rangesOf(VolumeSource& of, const BlockLayout& layout) {
    ProgressMeter progress;
    return std::make_shared<const SliceRanges>(buildSliceRanges(of, 0, layout, {pool, progress}));
  }
  const PyramidLayout& layout() const { return *step.pyramid; }

  VolumeSource& source;
  const MeanLevels means;
  WorkerPool pool;
  TimeStep step;
};

inline TransferFunction opaqueAbove(double threshold, double most, double opacity = 0.3) {
  TransferFunction transfer;
  transfer.colors = {{threshold, {0.2, 0.5, 1}}, {most, {1, 0.7, 0.1}}};
  transfer.opacities = {{threshold - 1e-6, 0}, {threshold, opacity / 2}, {most, opacity}};
  return transfer;
}

class LevelCutTest : public RenderTest {
 protected:
  // The blocks chosen for one view, by a planner of its own.
  static VisibleBlocksPtr chosen(const Pyramid& pyramid, const TransferFunction& transfer,
                                 const FrameOptions& options, const ReadLimit* limit = nullptr) {
    WorkerPool pool(2);
    ChunkNames names;
    Planner planner({{8, 8, 8}, 1, 1 << 12}, pool, names);
    const auto shared = std::make_shared<const TransferFunction>(transfer);
    const LookPtr look = planner.look(pyramid.step, shared, options.mode);
    return planner.visibleBlocks(
        Planner::question(pyramid.step, look, viewOf(pyramid, options), options, limit));
  }
  static View viewOf(const Pyramid& pyramid, const FrameOptions& options) {
    return resolve(options, pyramid.source.layout());
  }
  static std::unique_ptr<Session> sessionOf(Pyramid& pyramid, const TransferFunction& transfer,
                                            bool lit = false) {
    SessionOptions options;
    options.page = {
        {8, 8, 8}, static_cast<int64_t>(bytesPerVoxel(pyramid.step.ranges->map.type)), 1 << 12};
    options.memory_bytes = uint64_t{1} << 30;
    options.lit = lit;
    auto session = std::make_unique<Session>(pyramid.step, device(), pyramid.pool, options);
    session->setTransferFunction(transfer);
    return session;
  }
  struct Drawn {
    FloatPicture picture;
    FrameReport report;
  };
  static Drawn draw(Session& session, const FrameOptions& options) {
    session.setOptions(options);
    Frame frame = session.frame();
    FloatPicture picture;
    picture.width = frame.picture.width;
    picture.height = frame.picture.height;
    picture.rgba = std::move(frame.picture.rgba);
    return {std::move(picture), frame.report};
  }
};

inline std::unique_ptr<MemorySource> manyBlobs(Vec3i dims) {
  return makeSparseBlobs({.dims = dims, .type = VoxelType::kU8, .seed = 3, .blobs = 25});
}

// Each finest cell that shows something lies in the region of one chosen block at the most, and of
// one exactly unless its level shows nothing there.
inline void expectPartition(const Pyramid& pyramid, const VisibleBlocks& blocks) {
  const PyramidLayout& layout = pyramid.layout();
  int64_t cells = 0;
  for (size_t i = 0; i < blocks.blocks.size(); ++i) {
    const Box3 region = layout.regionOf(blocks.blocks[i].name);
    EXPECT_TRUE(region.contains(blocks.blocks[i].cells));
    EXPECT_FALSE(blocks.blocks[i].cells.empty());
    for (size_t j = i + 1; j < blocks.blocks.size(); ++j)
      EXPECT_TRUE(intersect(region, layout.regionOf(blocks.blocks[j].name)).empty());
    cells += blocks.blocks[i].cells.count();
  }
  int64_t reported = 0;
  for (const CutSummary::Level& level : blocks.cut->levels) reported += level.cells;
  EXPECT_EQ(reported, cells);
}

inline std::set<int32_t> levelsOf(const VisibleBlocks& blocks) {
  std::set<int32_t> levels;
  for (const ObjectBlock& block : blocks.blocks) levels.insert(block.name.level);
  return levels;
}

}  // namespace sluice
