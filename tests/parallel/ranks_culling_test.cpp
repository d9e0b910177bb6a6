// Compares the blocks that ranks see together in a series, each looking at its own tiles of the
// estimate, with those that a single process sees. Also series of pictures, read ahead, by ranks
// some of which have nothing to draw.
#include "src/parallel/rank_share.h"
#include "tests/parallel/rank_scene.h"
#include "tests/render/blob_scene.h"
#include "tests/render/culling_scene.h"

namespace sluice {
namespace {

constexpr int kSteps = 5;

std::unique_ptr<MemorySource> movingBlobs(Vec3i dims = {61, 50, 55}) {
  return makeSparseBlobs(
      {.dims = dims, .blobs = 14, .radius_vox = 12, .drift_vox = 2, .time_steps = kSteps});
}

class RanksCulling : public RenderTest {};

TEST_F(RanksCulling, findTogetherWhatOneFinds) {
  const auto source = movingBlobs();
  const TransferFunction transfer = thresholdTransfer(30, {0, 200}, 1, "viridis");
  CullingScene first(*source, transfer, 8);
  const TestSeries series = makeTestSeries(*source, first.ranges->layout, first.look->table);
  for (const Projection projection : kProjections)
    for (const bool uses_coherence : {false, true})
      for (const int ranks : {2, 5}) {
        const FrameOptions options = obliqueView(projection);
        const CullingOptions how{.uses_coherence = uses_coherence};
        WorkerPool alone_pool(1);
        CulledBlocks alone(series.opacity, source->layout(), how, alone_pool);
        std::vector<std::vector<int64_t>> expected(kSteps), found(kSteps);
        for (int64_t time = 0; time < kSteps; ++time) {
          CullingScene scene(*source, transfer, 8, time);
          for (const auto& block : alone.choose(scene.question(options))->blocks)
            expected[static_cast<size_t>(time)].push_back(block.name.block);
        }
        Mutex mutex;
        const auto ends = runInProcess(ranks, [&](Team& team) {
          WorkerPool pool(1);
          RankShare share(team, dealBlocks(first.ranges->layout, ranks), pool, UINT64_MAX);
          CullingOptions mine = how;
          share.shareEstimate(mine);
          share.dealEachPicture(uses_coherence);
          CulledBlocks culled(series.opacity, source->layout(), mine, pool);
          BlockChooser* chooser = share.chooserFrom(&culled);
          for (int64_t time = 0; time < kSteps; ++time) {
            CullingScene scene(*source, transfer, 8, time);
            const auto blocks = chooser->choose(scene.question(options));
            const MutexLock lock(mutex);
            for (const ObjectBlock& block : blocks->blocks)
              found[static_cast<size_t>(time)].push_back(block.name.block);
          }
        });
        EXPECT_THAT(ends, testing::Each(std::string()));
        for (std::vector<int64_t>& blocks : found) std::sort(blocks.begin(), blocks.end());
        EXPECT_EQ(found, expected);
        EXPECT_GT(expected[0].size(), 20U);
      }
}

// Two blocks of five ranks: three have none, and meet the others anyway.
TEST_F(RanksCulling, seriesOfPicturesThatAreReadAhead) {
  for (const Vec3i dims : {Vec3i{61, 50, 55}, Vec3i{14, 8, 8}}) {
    const auto source = movingBlobs(dims);
    const TransferFunction transfer = thresholdTransfer(10, {0, 200}, 0.6, "viridis");
    const SceneOptions how{.block_vox = 8, .threads = 1};
    CullingScene first(*source, transfer, 8);
    const TestSeries series = makeTestSeries(*source, first.ranges->layout, first.look->table);
    const FrameOptions options = obliqueView(Projection::kPerspective);
    const auto stepAt = [&](int64_t time) {
      auto ranges = std::make_shared<SliceRanges>(*CullingScene(*source, transfer, 8, time).ranges);
      ranges->device_range = first.ranges->device_range;
      return TimeStep{source.get(), time, std::move(ranges)};
    };
    std::vector<TimeStep> steps;
    for (int64_t time = 0; time < kSteps; ++time) steps.push_back(stepAt(time));
    std::vector<Picture> expected, found;
    RenderScene alone(device(), *source, transfer, how);
    WorkerPool pool(1);
    CulledBlocks culled(series.opacity, source->layout(), {}, pool);
    alone.session().chooseBlocksBy(&culled);
    alone.session().setOptions(options);
    for (const TimeStep& step : steps) {
      alone.session().setTimeStep(step);
      expected.push_back(alone.session().frame().picture);
    }
    const auto ends = runInProcess(5, [&](Team& team) {
      WorkerPool own_pool(1);
      RankShare share(team, dealBlocks(first.ranges->layout, 5), own_pool, UINT64_MAX);
      const auto part_device = share.deviceFrom(suiteDevice());
      RenderScene scene(*part_device, *source, transfer, how);
      CullingOptions mine;
      share.shareEstimate(mine);
      share.dealEachPicture(true);
      CulledBlocks own_culled(series.opacity, source->layout(), mine, own_pool);
      scene.session().chooseBlocksBy(share.chooserFrom(&own_culled));
      scene.session().setOptions(options);
      for (size_t i = 0; i < steps.size(); ++i) {
        scene.session().setTimeStep(steps[i]);
        if (i + 1 < steps.size()) scene.session().expectAfterwards(steps[i + 1]);
        scene.session().frame();
        Picture picture = share.picture();
        if (team.isFirst()) found.push_back(std::move(picture));
      }
    });
    EXPECT_THAT(ends, testing::Each(std::string()));
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i)
      EXPECT_LE(compare(found[i].rgba, expected[i].rgba, found[i].width).max_255, 1) << i;
  }
}

}  // namespace
}  // namespace sluice
