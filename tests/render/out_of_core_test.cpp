// Frames under small budgets and while data is late: the same picture, nothing read in vain, and
// the share missing at a time limit is reported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <random>
#include <unordered_set>

#include "src/classify/transfer/transfer_makers.h"
#include "src/texture/chunk_names.h"
#include "tests/render/render_scene.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/random_volume.h"

namespace sluice::out_of_core_test {
namespace {

constexpr Vec3i kDims{60, 52, 44};
constexpr PageGeometry kPage{{8, 8, 8}, 1, 1 << 12};

std::unique_ptr<MemorySource> blobs() {
  BlobOptions options;
  options.dims = kDims;
  options.type = VoxelType::kU8;
  options.blobs = 14;
  return makeSparseBlobs(options);
}

TransferFunction above(double threshold) {
  return thresholdTransfer(threshold, {0, 200}, 0.2, "viridis");
}

FrameOptions smallView() {
  return obliqueView(Projection::kPerspective, {48, 44});
}

class OutOfCoreTest : public RenderTest {
 protected:
  SliceRanges rangesOf(VolumeSource& source, int64_t block_vox, bool lit = false) {
    ProgressMeter silent;
    return buildSliceRanges(source, 0, blockLayout(kDims, block_vox, lit ? 1 : 0), {pool_, silent});
  }
  std::unique_ptr<Session> sessionOf(VolumeSource& source, const SliceRanges& ranges,
                                     SessionOptions options = {}) {
    options.page = options.page.pages == 0 ? kPage : options.page;
    if (options.memory_bytes == 0) options.memory_bytes = uint64_t{256} << 20;
    options.lit = ranges.layout.ghost == 1;
    auto session =
        std::make_unique<Session>(TimeStep{&source, 0, std::make_shared<const SliceRanges>(ranges)},
                                  device(), pool_, options);
    session->setTransferFunction(above(40));
    session->setOptions(smallView());
    return session;
  }
  std::vector<float> pictureOf(VolumeSource& source, const SliceRanges& ranges) {
    return sessionOf(source, ranges)->frame().picture.rgba;
  }

  WorkerPool pool_{2};
};

TEST_F(OutOfCoreTest, anyBudgetGivesTheSamePicture) {
  const auto source = blobs();
  for (const int64_t block : {8, 16, 32})
    for (const bool lit : {false, true}) {
      const SliceRanges ranges = rangesOf(*source, block, lit);
      SessionOptions options;
      options.page = {{8, 8, 8}, 1, block * block * block / 512};  // a block
      const std::vector<float> expected = sessionOf(*source, ranges, options)->frame().picture.rgba;
      const uint64_t least = textureMemoryBytes(options.page, TexelPlace::kInMemory) +
                             leastBufferBytes(options.page, {block});
      for (const uint64_t more : {0, 1, 100'000, 1'000'000, 100'000'000}) {
        SCOPED_TRACE(fmt::format("blocks of {}, lit {}, {} more than the least", block, lit, more));
        options.memory_bytes = least + more;
        const auto session = sessionOf(*source, ranges, options);
        for (int frame = 0; frame < 2; ++frame)
          EXPECT_EQ(session->frame().picture.rgba, expected) << "frame " << frame;
        const CacheCounters blocks = session->volumeBufferCounters(),
                            chunks = session->textureBufferCounters();
        EXPECT_EQ(blocks.brokenIdentity(), "");
        EXPECT_EQ(chunks.brokenIdentity(), "");
        EXPECT_LE(blocks.peak_bytes + chunks.peak_bytes +
                      session->textureCache().counters().peak_bytes + spareTextureBytes(0),
                  options.memory_bytes);
      }
    }
}

TEST_F(OutOfCoreTest, manyViewsAndThresholdsUnderTheLeastBudget) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 16);
  std::mt19937 random(5);
  for (const int64_t blocks_in_cache : {1, 3, 8}) {
    SessionOptions options;
    options.page = {{8, 8, 8}, 1, blocks_in_cache * 8};
    const auto roomy = sessionOf(*source, ranges, options);
    options.memory_bytes = textureMemoryBytes(options.page, TexelPlace::kInMemory) +
                           leastBufferBytes(options.page, {16});
    const auto tight = sessionOf(*source, ranges, options);
    for (int i = 0; i < 40; ++i) {
      FrameOptions view = smallView();
      view.camera.azimuth_deg = static_cast<double>(random() % 360);
      view.camera.elevation_deg = static_cast<double>(random() % 180) - 90;
      const TransferFunction transfer = above(static_cast<double>(20 + random() % 120));
      std::vector<float> pictures[2];
      for (int s = 0; s < 2; ++s) {
        Session& session = s == 0 ? *roomy : *tight;
        session.setTransferFunction(transfer);
        session.setOptions(view);
        pictures[s] = session.frame().picture.rgba;
      }
      ASSERT_EQ(pictures[0], pictures[1]) << blocks_in_cache << " blocks, frame " << i;
    }
    EXPECT_EQ(tight->textureBufferCounters().brokenIdentity(), "");
    EXPECT_EQ(tight->volumeBufferCounters().brokenIdentity(), "");
  }
}

TEST_F(OutOfCoreTest, whiteBlocksAreNeverRead) {
  const auto source = blobs();
  CountingSource counting(*source);
  const SliceRanges ranges = rangesOf(*source, 16);
  const auto session = sessionOf(counting, ranges);
  const FrameReport report = session->frame().report;
  EXPECT_GT(report.blocks.white, 0);
  EXPECT_EQ(counting.reads().size(), static_cast<size_t>(report.blocks.grey + report.blocks.black));
  EXPECT_EQ(static_cast<uint64_t>(counting.counts().bytes), report.decoded_bytes);
  EXPECT_EQ(report.decoded_bytes, report.rebuild.decoded);
  EXPECT_EQ(report.copied_bytes, report.rebuild.copied);
  EXPECT_EQ(report.uploaded_bytes, copied(report.rebuild.uploaded));
}

// Voxels of chunks whose recipe no plan before had, counted from the plans alone.
class ChangedVoxels {
 public:
  uint64_t of(const TexturePlan& plan) {
    uint64_t voxels = 0;
    const ChunkNameList names = names_.namesOf(plan);
    for (const ChunkPosition i : names.indices())
      if (seen_.insert(names[i]).second)
        for (const BlockPosition block : plan.chunks[i].blocks)
          voxels += static_cast<uint64_t>(plan.blocks[block].voxels.count());
    return voxels;
  }

 private:
  ChunkNames names_;
  std::unordered_set<ChunkName> seen_;
};

TEST_F(OutOfCoreTest, aChangedThresholdCopiesTheChangedChunksAndReadsTheNewBlocksAlone) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  for (const Algorithm algorithm : {Algorithm::kTrimmed, Algorithm::kMerged}) {
    CountingSource counting(*source);
    const auto session = sessionOf(counting, ranges);
    FrameOptions options = smallView();
    options.algorithm = algorithm;
    session->setOptions(options);
    ChangedVoxels changed;
    std::unordered_set<int64_t> held;  // blocks
    BlockClasses before;
    for (const double threshold : {90.0, 91.0, 60.0, 20.0, 150.0, 150.5, 60.0}) {
      SCOPED_TRACE(threshold);
      const OpacityTable table(above(threshold), ranges.map, ranges.device_range);
      const Box3 all = boxOf(kDims - Vec3i{1, 1, 1});
      const VisibleBlocks classes = classify(ranges, table, all, pool_);
      int64_t fresh = 0;
      for (const ObjectBlock& block : classes.blocks) fresh += held.insert(block.name.block).second;
      counting.reset();
      session->setTransferFunction(above(threshold));
      const FrameReport report = session->frame().report;
      EXPECT_EQ(report.copied_bytes,
                changed.of(planTextures(ranges.layout, classes, kPage,
                                        {algorithm, MergeOrder::kPaper, 0, all})));
      EXPECT_EQ(counting.reads().size(), static_cast<size_t>(fresh));
      EXPECT_EQ(report.before.white, before.white);
      EXPECT_EQ(report.before.black, before.black);
      before = report.blocks;
      EXPECT_EQ(report.blocks.white + report.blocks.grey + report.blocks.black,
                ranges.layout.blockCount());
    }
  }
}

TEST_F(OutOfCoreTest, atTheTimeLimitWhatIsThereIsDrawnAndTheNextFramesCompleteIt) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  const std::vector<float> expected = pictureOf(*source, ranges);
  FailingSource stalled(*source, FailingSource::Failure::kStall, 5, FailingSource::kForever);
  const auto session = sessionOf(stalled, ranges);
  FrameOptions options = smallView();
  options.time_limit_s = 0.02;
  session->setOptions(options);
  Frame frame = session->frame();
  EXPECT_GT(frame.report.missing_share, 0);
  EXPECT_LE(frame.report.missing_share, 1);
  EXPECT_NE(frame.picture.rgba, expected);
  stalled.release();
  int frames = 0;
  double missing = 1;
  for (; missing > 0 && frames < 1000; ++frames) {
    frame = session->frame();
    EXPECT_LE(frame.report.missing_share, missing);
    missing = frame.report.missing_share;
  }
  EXPECT_EQ(missing, 0);
  EXPECT_EQ(frame.picture.rgba, expected);
  EXPECT_EQ(session->volumeBufferCounters().brokenIdentity(), "");
}

TEST_F(OutOfCoreTest, anUnlimitedFrameCompletesALimitedOne) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  const std::vector<float> expected = pictureOf(*source, ranges);
  const auto session = sessionOf(*source, ranges);
  FrameOptions options = smallView();
  options.time_limit_s = 0;
  session->setOptions(options);
  session->frame();
  session->setOptions(smallView());
  const Frame frame = session->frame();
  EXPECT_EQ(frame.report.missing_share, 0);
  EXPECT_EQ(frame.picture.rgba, expected);
}

TEST_F(OutOfCoreTest, whatAChangedThresholdMakesUselessIsNotRead) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  CountingSource counting(*source);
  FailingSource stalled(counting, FailingSource::Failure::kStall, 0, FailingSource::kForever);
  const auto session = sessionOf(stalled, ranges);
  FrameOptions options = smallView();
  options.time_limit_s = 0;
  session->setOptions(options);
  const FrameReport limited = session->frame().report;
  stalled.waitUntilStalled();
  session->setTransferFunction(above(1000));  // nothing is visible
  stalled.release();
  EXPECT_EQ(session->frame().report.missing_share, 0);
  // Only the runs under way when the change came were read: one per reader.
  EXPECT_LT(counting.reads().size(),
            static_cast<size_t>(limited.blocks.grey + limited.blocks.black) / 2);
}

TEST_F(OutOfCoreTest, aReadThatStallsIsWaitedFor) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  const std::vector<float> expected = pictureOf(*source, ranges);
  FailingSource stalled(*source, FailingSource::Failure::kStall, 3);
  const auto session = sessionOf(stalled, ranges);
  auto helper = std::async(std::launch::async, [&] {
    stalled.waitUntilStalled();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    stalled.release();
  });
  EXPECT_EQ(session->frame().picture.rgba, expected);
}

TEST_F(OutOfCoreTest, aFailureAheadEndsTheFrameThatNeedsItAndNoOther) {
  const auto source = blobs();
  const SliceRanges ranges = rangesOf(*source, 8);
  const std::vector<float> expected = pictureOf(*source, ranges);
  FailingSource failing(*source, FailingSource::Failure::kError, 20);
  const auto session = sessionOf(failing, ranges);
  EXPECT_THROW(session->frame(), Error);
  EXPECT_EQ(session->frame().picture.rgba, expected);
}

}  // namespace
}  // namespace sluice::out_of_core_test
