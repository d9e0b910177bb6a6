// Real volumes through caches too small for them: the model's counts equal those of the device and
// of the source, and no identity of the counters breaks, at any level (design, points 4 and 5).
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render/real_volumes.h"
#include "tests/render/render_scene.h"
#include "tests/support/counting_source.h"

namespace sluice::real_accounting_test {
namespace {

constexpr int64_t kBlock = 32;
constexpr Vec3i kPage{16, 16, 8};
constexpr int64_t kPagesOfABlock = 16;

class RealAccountingTest : public RenderTest, public testing::WithParamInterface<RealVolume> {
 protected:
  // A number of pages that makes the algorithm evict: a third of its plan's pages, minus a block.
  static int64_t tooFewPages(const SliceRanges& ranges, const TransferFunction& transfer,
                             Algorithm algorithm) {
    WorkerPool pool(2);
    const OpacityTable table(transfer, ranges.map, ranges.device_range);
    const Box3 cells = boxOf(ranges.layout.dims - Vec3i{1, 1, 1});
    const PageGeometry page{kPage, static_cast<int64_t>(bytesPerVoxel(ranges.map.type)), 1 << 15};
    const TexturePlan plan = planTextures(
        ranges.layout, classify(ranges, table, cells, pool), page,
        {algorithm == Algorithm::kMerged ? Algorithm::kTrimmed : algorithm, {}, 0, cells});
    return std::max(kPagesOfABlock, plan.pageCount() / 3);
  }

  // Draws `frames` frames of a turn and compares the counts of the observers.
  static void expectEqualBytesOverATurn(VolumeSource& source, int64_t time,
                                        const TransferFunction& transfer, PolicyKind policy,
                                        Algorithm algorithm, int64_t pages, int frames) {
    const uint64_t before = device().uploadedBytes();
    CountingSource counting(source);
    RenderScene scene(
        device(), counting, transfer,
        {.block_vox = kBlock, .page_vox = kPage, .pages = pages, .policy = policy, .time = time});
    counting.reset();  // the min-max arrays read everything
    uint64_t by_frames = 0;
    for (int i = 0; i < frames; ++i) {
      FrameOptions options = obliqueView(Projection::kPerspective, {24, 24});
      options.camera.azimuth_deg = 360.0 * i / frames;
      options.algorithm = algorithm;
      const uint64_t uploaded = device().uploadedBytes();
      // Checks the identities of each level too.
      const FrameReport report = scene.frame(options).report;
      ASSERT_EQ(report.uploaded_bytes, device().uploadedBytes() - uploaded) << "frame " << i;
      by_frames += report.uploaded_bytes;
    }
    const TextureCache& model = scene.session().textureCache();
    const CacheCounters counted = model.counters();
    EXPECT_GT(counted.uploaded_bytes, 0U);
    EXPECT_EQ(copied(counted.uploaded_bytes), by_frames);
    EXPECT_EQ(copied(counted.uploaded_bytes), device().uploadedBytes() - before);
    EXPECT_EQ(counted.uploaded_bytes,
              model.pagesLoaded() * static_cast<uint64_t>(scene.session().page().pageBytes()));
    EXPECT_LE(model.usedPages(), static_cast<uint64_t>(pages));
    EXPECT_LE(counted.peak_bytes,
              static_cast<uint64_t>(pages * scene.session().page().pageBytes()));
    const CacheCounters blocks = scene.session().volumeBufferCounters();
    EXPECT_EQ(blocks.decoded_bytes, static_cast<uint64_t>(counting.counts().bytes));
    EXPECT_GT(counted.evictions, 0U) << "too many pages to mean anything";
  }
};

TEST_P(RealAccountingTest, aTurnOf36FramesUploadsTheBytesThatTheModelCounts) {
  const auto source = openReal(GetParam());
  if (!source) GTEST_SKIP() << GetParam().input << " is not there";
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges = buildSliceRanges(
      *source, GetParam().time, blockLayout(source->layout().dims, kBlock, 0), {pool, progress});
  const TransferFunction transfer = automaticFor(ranges, source->layout());
  expectEqualBytesOverATurn(*source, GetParam().time, transfer, PolicyKind::kLru,
                            Algorithm::kMerged, tooFewPages(ranges, transfer, Algorithm::kMerged),
                            36);
}

// The middle of the volume stands for it.
TEST_P(RealAccountingTest, everyPolicyAndAlgorithmUploadsTheBytesThatTheModelCounts) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const auto source = middleOf(*file, {72, 72, 72}, GetParam().time);
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges =
      buildSliceRanges(*source, 0, blockLayout(source->layout().dims, kBlock, 0), {pool, progress});
  const TransferFunction transfer = automaticFor(ranges, file->layout());
  for (const Algorithm algorithm : kAlgorithms) {
    const int64_t pages = tooFewPages(ranges, transfer, algorithm);
    for (const PolicyKind policy : onlinePolicies()) {
      SCOPED_TRACE(fmt::format("{}, {}, {} pages", name(algorithm), name(policy), pages));
      expectEqualBytesOverATurn(*source, 0, transfer, policy, algorithm, pages, 3);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Data, RealAccountingTest, testing::ValuesIn(realVolumes()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sluice::real_accounting_test
