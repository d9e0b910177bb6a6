// Culling against every sample of every ray: no block that rays reach may be missing, and pictures
// differ by no more than the opacity threshold allows.
#include <gtest/gtest.h>

#include <new>
#include <random>

#include "tests/render/blob_scene.h"
#include "tests/render/culling_scene.h"
#include "tests/support/failing_memory.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

// Something solid with holes in it, of many shades.
std::unique_ptr<MemorySource> rocks(uint64_t seed, Vec3i dims = {50, 45, 61}, int64_t steps = 1,
                                    Vec3d spacing = {1, 1, 1}) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.time_steps = steps;
  layout.spacing = spacing;
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> unit(0, 1);
  struct Hole {
    Vec3d at, way;
    double radius;
  };
  std::vector<Hole> holes(7);
  for (Hole& hole : holes)
    hole = {Vec3d{unit(random), unit(random), unit(random)} * toDouble(dims),
            {2 * unit(random) - 1, 2 * unit(random) - 1, 2 * unit(random) - 1},
            2 + 9 * unit(random)};
  return makeMemorySource<uint8_t>(layout, [=](int64_t x, int64_t y, int64_t z, int64_t t) {
    const Vec3d p = toDouble({x, y, z});
    double value = 120 + 40 * std::sin(0.4 * p.x) * std::sin(0.3 * p.y + 0.2 * p.z);
    for (const Hole& hole : holes) {
      const double d = length(p - hole.at - hole.way * static_cast<double>(t)) / hole.radius;
      value *= std::clamp(3 * (d - 0.8), 0.0, 1.0);
    }
    return value;
  });
}

TransferFunction looks(int which) {
  if (which == 0) return thresholdTransfer(30, {0, 200}, 1, "grey");  // an opaque surface
  if (which == 1) return thresholdTransfer(30, {0, 200}, 0.4, "grey");
  TransferFunction bands;  // opaque layers with nothing in between
  bands.colors = {{0, {1, 1, 1}}};
  bands.opacities = {{0, 0}, {60, 0}, {70, 0.6}, {100, 0.6}, {110, 0.01}, {140, 0.5}, {255, 0.8}};
  return bands;
}

TEST(Culling, noBlockIsCulledThatRaysReach) {
  std::mt19937 random(1);
  ReachedCounts counts;
  for (int scene_at = 0; scene_at < 18; ++scene_at) {
    const Vec3d spacing = scene_at % 3 == 2 ? Vec3d{1, 1.7, 0.8} : Vec3d{1, 1, 1};
    const auto source = rocks(static_cast<uint64_t>(scene_at), {50, 45, 61}, 1, spacing);
    const int64_t block = scene_at % 2 == 0 ? 16 : 8;
    CullingScene scene(*source, looks(scene_at % 3), block);
    const TestSeries series =
        makeTestSeries(*source, scene.ranges->layout, scene.look->table,
                       {.part_cells = scene_at % 4 == 1 ? 8 : 4, .directions = {3 + scene_at % 3}});
    for (int i = 0; i < 30; ++i) {
      SCOPED_TRACE(testing::Message() << "scene " << scene_at << " view " << i);
      const double threshold = i % 4 == 0 ? 254.0 / 255 : i % 4 == 1 ? 0.5 : 0.95;
      expectNothingReachedIsCulled(scene, series, randomView(random, source->layout()), threshold,
                                   counts);
    }
  }
  EXPECT_LT(counts.visible, counts.nonempty * 9 / 10) << "else nothing is tested";
  EXPECT_LT(counts.visible, 2 * counts.reached);
}

TEST(Culling, whatEveryRayReachesIsWhatASlabHides) {
  VolumeLayout layout;
  layout.dims = {33, 33, 65};
  const auto source = makeMemorySource<uint8_t>(
      layout, [](int64_t, int64_t, int64_t z) { return z >= 20 && z <= 28 ? 200 : 1; });
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{0, 0.001}, {100, 0.001}, {200, 1}};
  CullingScene scene(*source, transfer, 16);
  FrameOptions options;
  options.size = {64, 64};
  options.camera.azimuth_deg = 0;  // along -z: from the far end
  const std::vector<bool> truth = scene.reached(options, 0.95);
  for (size_t block = 0; block < truth.size(); ++block)
    EXPECT_EQ(truth[block], block / 9 >= 1) << block;  // 3 x 3 x 5 blocks of 15 cells
  const TestSeries series = makeTestSeries(*source, scene.ranges->layout, scene.look->table);
  CulledBlocks culled(series.opacity, layout, {}, scene.pool);
  const auto found = culled.choose(scene.question(options));
  EXPECT_EQ(found->blocks.size(), 36U);
  EXPECT_EQ(culled.counts().blocks_nonempty, 45);
}

TEST(Culling, stepsOfASeriesAreTheSameWithTheTreeAndWithout) {
  const auto source = rocks(5, {50, 45, 61}, 12);
  FrameOptions options = obliqueView(Projection::kOrtho);
  for (const double difference : {0.0, 1e-4, 1e-2}) {
    CullingScene first(*source, looks(0), 8);
    SeriesPassOptions pass;
    pass.difference = difference;
    const TestSeries series =
        makeTestSeries(*source, first.ranges->layout, first.look->table, pass);
    CulledBlocks coherent(series.opacity, source->layout(), {}, first.pool);
    CulledBlocks plain(series.opacity, source->layout(), {.uses_coherence = false}, first.pool);
    // With room for next to nothing of what it would keep, and for no part that changes.
    CulledBlocks tight(series.opacity, source->layout(), {.most_kept_bytes = 5000}, first.pool);
    int64_t checked = 0, all = 0;
    for (const int64_t time : {0, 1, 2, 3, 7, 8, 4, 11, 11, 0}) {
      CullingScene scene(*source, looks(0), 8, time);
      const auto a = coherent.choose(scene.question(options));
      const auto b = plain.choose(scene.question(options));
      const auto c = tight.choose(scene.question(options));
      ASSERT_EQ(a->blocks.size(), b->blocks.size());
      ASSERT_EQ(a->blocks.size(), c->blocks.size());
      for (size_t i = 0; i < a->blocks.size(); ++i) {
        EXPECT_EQ(a->blocks[i].name.block, b->blocks[i].name.block);
        EXPECT_EQ(a->blocks[i].name.block, c->blocks[i].name.block);
      }
      const std::vector<bool> truth = scene.reached(options, 0.95);
      std::vector<bool> is_visible(truth.size(), false);
      for (const ObjectBlock& block : a->blocks)
        is_visible[static_cast<size_t>(block.name.block)] = true;
      for (size_t i = 0; i < truth.size(); ++i)
        if (truth[i] && !series.steps[static_cast<size_t>(time)].isEmpty(static_cast<int64_t>(i))) {
          EXPECT_TRUE(is_visible[i]) << "step " << time << " block " << i;
        }
      if (time == 0) continue;
      checked += coherent.counts().pixels_checked;
      all += plain.counts().pixels_checked;
    }
    EXPECT_LE(checked, all);
    if (difference > 1e-3) {
      EXPECT_LT(checked, all * 9 / 10);
    }
  }
}

// The numbers of the blocks that an answer has.
std::vector<int64_t> numbersOf(const VisibleBlocksPtr& answer) {
  std::vector<int64_t> numbers;
  for (const ObjectBlock& block : answer->blocks) numbers.push_back(block.name.block);
  return numbers;
}

TEST(Culling, aStepThatFoundNoMemoryIsEstimatedAgain) {
  const auto source = rocks(5, {50, 45, 61}, 2);
  const FrameOptions options = obliqueView(Projection::kOrtho);
  CullingScene first(*source, looks(0), 8), second(*source, looks(0), 8, 1);
  const TestSeries series = makeTestSeries(*source, first.ranges->layout, first.look->table, {});
  WorkerPool alone(1);  // all allocations are this thread's
  const auto blocksOf = [&] { return CulledBlocks(series.opacity, source->layout(), {}, alone); };
  CulledBlocks untroubled = blocksOf();
  const BlockQuestion question = second.question(options);
  const std::vector<int64_t> expected = numbersOf(untroubled.choose(question));
  forEachAllocation([&](int64_t n) {
    CulledBlocks culled = blocksOf();
    culled.choose(first.question(options));
    bool failed = false;
    {
      const FailingMemory memory(n);
      try {
        culled.choose(question);
      } catch (const std::bad_alloc&) {
      }
      failed = memory.failed();
    }
    EXPECT_EQ(numbersOf(culled.choose(question)), expected) << n;
    return failed;
  });
}

TEST(Culling, aViewWhoseQuestionFailedIsForgotten) {
  const auto source = rocks(5);
  CullingScene scene(*source, looks(0), 8);
  const TestSeries series = makeTestSeries(*source, scene.ranges->layout, scene.look->table, {});
  FrameOptions front = obliqueView(Projection::kOrtho), back = front;
  back.camera.azimuth_deg += 180;
  bool fails = false;
  CullingOptions options;
  options.exchange = [&](int64_t, std::vector<bool>&) {
    if (fails) throw Error("another rank is gone");
  };
  CulledBlocks culled(series.opacity, source->layout(), options, scene.pool);
  const std::vector<int64_t> expected = numbersOf(culled.choose(scene.question(front)));
  fails = true;
  EXPECT_THROW(culled.choose(scene.question(back)), Error);
  fails = false;
  // The same view with other blocks than before, since their look is made anew.
  CullingScene again(*source, looks(0), 8);
  EXPECT_EQ(numbersOf(culled.choose(again.question(front))), expected);
}

TEST(Culling, pictureDiffersByWhatOpaqueLeaves) {
  for (int which = 0; which < 3; ++which) {
    const auto source = rocks(7);
    PlainDevice device;
    RenderScene scene(device, *source, looks(which), {.block_vox = 8});
    const Look look = makeLook(scene.step(), looks(which), Mode::kComposite);
    const TestSeries series = makeTestSeries(*source, scene.ranges().layout, look.table);
    WorkerPool pool(2);
    for (const Projection projection : kProjections) {
      const FrameOptions options = obliqueView(projection);
      scene.session().chooseBlocksBy(nullptr);
      const Frame all = scene.frame(options);
      for (const double threshold : {0.95, 254.0 / 255}) {
        CulledBlocks culled(series.opacity, source->layout(), {OpacityForm::kOpof, threshold},
                            pool);
        scene.session().chooseBlocksBy(&culled);
        const Frame frame = scene.frame(options);
        if (which == 0) {
          EXPECT_LT(frame.report.blocks.grey + frame.report.blocks.black,
                    all.report.blocks.grey + all.report.blocks.black);
        }
        float most = 0;
        for (size_t i = 0; i < all.picture.rgba.size(); ++i)
          most = std::max(most, std::abs(all.picture.rgba[i] - frame.picture.rgba[i]));
        EXPECT_LE(255 * most, threshold > 0.99 ? 2 : 13);
      }
      scene.session().chooseBlocksBy(nullptr);
    }
  }
}

TEST(Culling, whatIsCutAwayHidesNothing) {
  const auto source = rocks(9);
  CullingScene scene(*source, looks(0), 8);
  const TestSeries series = makeTestSeries(*source, scene.ranges->layout, scene.look->table);
  PlainDevice device;
  RenderScene drawn(device, *source, looks(0), {.block_vox = 8});
  for (int i = 0; i < 4; ++i) {
    FrameOptions options = obliqueView(i % 2 == 0 ? Projection::kOrtho : Projection::kPerspective);
    CullingOptions culling;
    if (i < 2) {
      options.crop = Box3{{0, 0, 0}, {50, 45, 27}};
    } else {
      const Vec3d normal =
          resolve(options.camera, source->layout(), options.size, 1).forward * -1.0;
      options.clip_planes = {{normal, dot(normal, Vec3d{25, 22, 30})}};
      culling.clip_planes = options.clip_planes;
    }
    const Frame all = drawn.frame(options);
    CulledBlocks culled(series.opacity, source->layout(), culling, scene.pool);
    drawn.session().chooseBlocksBy(&culled);
    const Frame frame = drawn.frame(options);
    drawn.session().chooseBlocksBy(nullptr);
    EXPECT_LT(frame.report.blocks.grey + frame.report.blocks.black,
              all.report.blocks.grey + all.report.blocks.black);
    float most = 0;
    for (size_t k = 0; k < all.picture.rgba.size(); ++k)
      most = std::max(most, std::abs(all.picture.rgba[k] - frame.picture.rgba[k]));
    EXPECT_LE(255 * most, 13) << i;
  }
}

// The blocks that the next step needs, and no others, are in the buffers when it is drawn.
TEST(Culling, theNextStepIsReadWhileOneIsDrawn) {
  const auto source = rocks(5, {50, 45, 61}, 3);
  PlainDevice device;
  RenderScene scene(device, *source, looks(0), {.block_vox = 8, .threads = 1});
  const TestSeries series = makeTestSeries(
      *source, scene.ranges().layout, makeLook(scene.step(), looks(0), Mode::kComposite).table);
  WorkerPool pool(2);
  CulledBlocks culled(series.opacity, source->layout(), {}, pool);
  Session& session = scene.session();
  session.chooseBlocksBy(&culled);
  CullingScene next(*source, looks(0), 8, 1);
  const FrameOptions options = obliqueView(Projection::kOrtho);
  session.expectAfterwards(next.step);
  // Not by scene.frame(): its counters are those of a session at rest, and this session reads on.
  session.setOptions(options);
  session.frame();
  const CullingCounts first = culled.countsOf(0), second = culled.countsOf(1);
  EXPECT_GT(first.blocks_visible, 0);
  session.setTimeStep(next.step);
  const uint64_t requests = session.textureBufferCounters().requests;
  const Frame frame = session.frame();
  EXPECT_EQ(frame.report.blocks.grey + frame.report.blocks.black, second.blocks_visible);
  EXPECT_GT(session.textureBufferCounters().requests, requests);
  // Each visible block of both steps was loaded once at the most, whoever asked for it.
  EXPECT_LE(session.volumeBufferCounters().loads,
            static_cast<uint64_t>(first.blocks_visible + second.blocks_visible));
  PlainDevice other_device;
  RenderScene other(other_device, *source, looks(0), {.block_vox = 8, .time = 1});
  other.session().chooseBlocksBy(&culled);
  EXPECT_EQ(other.frame(options).picture.rgba, frame.picture.rgba);
  session.chooseBlocksBy(nullptr);
}

TEST(Culling, theSameAnswerIsTheSameObject) {
  const auto source = rocks(9);
  CullingScene scene(*source, looks(0), 8);
  const TestSeries series = makeTestSeries(*source, scene.ranges->layout, scene.look->table);
  CulledBlocks culled(series.opacity, source->layout(), {}, scene.pool);
  FrameOptions options = obliqueView(Projection::kOrtho);
  const auto first = culled.choose(scene.question(options));
  EXPECT_EQ(culled.choose(scene.question(options)), first);
  options.camera.azimuth_deg += 90;
  EXPECT_NE(culled.choose(scene.question(options)), first);
}

}  // namespace
}  // namespace sluice
