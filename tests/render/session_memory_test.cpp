// A session within its budgets: accounting at every level against a second observer, and the same
// picture from little memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <charconv>
#include <string>
#include <vector>

#include "cache/simulate/simulator.h"
#include "src/base/error.h"
#include "src/render/session/session.h"
#include "src/texture/chunk_names.h"
#include "src/texture/frame_trace.h"
#include "tests/render/blob_scene.h"
#include "tests/support/counting_source.h"

namespace sluice {
namespace {

using testing::HasSubstr;

using SessionTest = RenderTest;

// Design, point 5: the model decides, the device obeys. Turntables through a cache of a few pages.
TEST_F(SessionTest, modelAndDeviceCountTheSameBytes) {
  const auto source = blobs();
  struct {
    Vec3i page;
    int64_t pages;
  } const geometries[] = {{{8, 8, 8}, 4}, {{8, 8, 8}, 16}, {{4, 4, 2}, 128}, {{8, 4, 1}, 64}};
  for (const auto& [page, pages] : geometries)
    for (const PolicyKind policy : onlinePolicies())
      for (const Algorithm algorithm : kAlgorithms) {
        SCOPED_TRACE(fmt::format("{} pages of {} x {} x {}, policy {}, {}", pages, page.x, page.y,
                                 page.z, name(policy), name(algorithm)));
        const uint64_t before = device().uploadedBytes();
        RenderScene scene(device(), *source, someTransfer(),
                          {.block_vox = 8, .page_vox = page, .pages = pages, .policy = policy});
        uint64_t by_frames = 0;
        for (const double azimuth : {0.0, 50.0, 180.0, 185.0}) {
          FrameOptions options = smallView(azimuth);
          options.size = {24, 24};
          options.algorithm = algorithm;
          by_frames += scene.frame(options).report.uploaded_bytes;
        }
        const TextureCache& model = scene.session().textureCache();
        EXPECT_EQ(copied(model.counters().uploaded_bytes), device().uploadedBytes() - before);
        EXPECT_EQ(copied(model.counters().uploaded_bytes), by_frames);
        EXPECT_EQ(model.counters().uploaded_bytes,
                  model.pagesLoaded() * static_cast<uint64_t>(volume(page)));
        EXPECT_GT(model.counters().evictions, 0U) << "too many pages to mean anything";
        EXPECT_LE(model.usedPages(), static_cast<uint64_t>(pages));
      }
}

// Design, points 1 and 5: the plan alone determines what a frame will move.
TEST_F(SessionTest, recordedRequestsAreThoseOfThePlanAndSimulateToTheSameBytes) {
  class Recorder : public TraceWriter {
   public:
    void write(const TraceRecord& record) override { records.push_back(record); }
    void finish() override {}
    std::vector<TraceRecord> records;
  };
  const auto source = blobs();
  for (const Algorithm algorithm : kAlgorithms) {
    SCOPED_TRACE(name(algorithm));
    RenderScene scene(device(), *source, someTransfer(), {.block_vox = 8, .pages = 16});
    Recorder recorder;
    scene.session().recordTo(&recorder);
    uint64_t uploaded = 0;
    std::vector<TraceRecord> expected;
    WorkerPool pool(1);
    for (int64_t frame = 0; frame < 3; ++frame) {
      FrameOptions options = smallView(70.0 * static_cast<double>(frame));
      options.algorithm = algorithm;
      uploaded += scene.frame(options).report.uploaded_bytes;

      const SliceRanges& ranges = scene.ranges();
      const OpacityTable table(someTransfer(), ranges.map, ranges.device_range);
      const Box3 cells = boxOf(source->layout().dims - Vec3i{1, 1, 1});
      const TexturePlan plan =
          planTextures(ranges.layout, classify(ranges, table, cells, pool), scene.session().page(),
                       {algorithm, options.merge_order, 0, cells});
      ChunkNames names;
      const View view = resolve(options, source->layout());
      for (const TraceRecord& record :
           frameRequests(plan, names.namesOf(plan), eyePosition(view, source->layout()), frame))
        expected.push_back(record);
    }
    scene.session().recordTo(nullptr);
    EXPECT_EQ(recorder.records, expected);
    EXPECT_EQ(scene.session().textureCache().counters().requests, expected.size());
    const auto page_bytes = static_cast<uint64_t>(scene.session().page().pageBytes());
    const SimulationRow simulated =
        simulate(prepare({page_bytes, expected}), {.pages = 16, .pin_clusters = true});
    EXPECT_EQ(copied(simulated.bytes.moved), uploaded);
    EXPECT_EQ(simulated.chunks.evictions, scene.session().textureCache().counters().evictions);
    scene.frame(smallView());
    EXPECT_EQ(recorder.records.size(), expected.size()) << "no longer recorded";
  }
}

TEST_F(SessionTest, fewPagesGiveTheSamePicture) {
  const auto source = blobs();
  for (const bool lit : {false, true})
    for (const Algorithm algorithm : kAlgorithms) {
      FrameOptions options = smallView();
      options.algorithm = algorithm;
      RenderScene roomy(device(), *source, someTransfer(), {.block_vox = 8, .lit = lit});
      const FloatPicture expected = roomy.draw(options);
      EXPECT_TRUE(within(2, expected, roomy.reference(options)));
      for (const int64_t pages : {1, 2, 8, 64}) {
        RenderScene scene(device(), *source, someTransfer(),
                          {.block_vox = 8, .pages = pages, .lit = lit});
        EXPECT_TRUE(within(0.1, scene.draw(options), expected)) << pages << " pages";
        EXPECT_TRUE(within(0.1, scene.draw(options), expected)) << pages << " pages, again";
      }
    }
}

TEST_F(SessionTest, cacheSmallerThanABlockIsAnError) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer(),
                    {.block_vox = 16, .page_vox = {8, 8, 8}, .pages = 4});
  try {
    scene.frame(smallView());
    FAIL() << "4 pages of 8^3 hold no block of 16^3";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("--pages 8"));
  }
}

// The number after the last "--memory" of the message.
uint64_t leastMemoryIn(const std::string& message) {
  const size_t at = message.rfind("--memory ");
  uint64_t bytes = 0;
  if (at != std::string::npos)
    std::from_chars(message.data() + at + 9, message.data() + message.size(), bytes);
  return bytes;
}

TEST_F(SessionTest, tooLittleMemoryNamesTheLeastThatWorksAndThatWorks) {
  struct {
    int64_t block;
    Vec3i page;
    int64_t pages;
  } const geometries[] = {
      {8, {8, 8, 8}, 8}, {16, {32, 64, 2}, 8}, {8, {64, 32, 32}, 2}, {32, {4, 4, 4}, 1024}};
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kF64})
    for (const bool lit : {false, true})
      for (const auto& [block, page, pages] : geometries)
        for (const int threads : {1, 2, 5}) {
          SCOPED_TRACE(fmt::format("blocks of {}, page {} {} {}, {} threads, {}, lit {}", block,
                                   page.x, page.y, page.z, threads, name(type), lit));
          const auto source = blobs({48, 40, 36}, type);
          const double top = type == VoxelType::kU8 ? 200 : 200.0 / 255;
          const TransferFunction transfer = thresholdTransfer(0.2 * top, {0, top}, 0.2, "viridis");
          SceneOptions options{.block_vox = block,
                               .page_vox = page,
                               .pages = pages,
                               .memory_bytes = 1,
                               .threads = threads,
                               .lit = lit};
          uint64_t least = 0;
          try {
            RenderScene scene(device(), *source, transfer, options);
            FAIL() << "one byte is not enough";
          } catch (const Error& error) {
            const std::string message = error.what();
            EXPECT_EQ(message.find('\n'), std::string::npos) << message;
            least = leastMemoryIn(message);
          }
          ASSERT_GT(least, 1U);
          options.memory_bytes = least - 1;
          EXPECT_THROW(RenderScene(device(), *source, transfer, options), Error);
          options.memory_bytes = least;
          RenderScene scene(device(), *source, transfer, options);
          for (const Algorithm algorithm : kAlgorithms) {
            FrameOptions view = smallView();
            view.size = {24, 24};
            view.algorithm = algorithm;
            const FloatPicture drawn = scene.draw(view);
            EXPECT_TRUE(within(2, drawn, scene.reference(view))) << name(algorithm);
          }
          const Session& session = scene.session();
          const uint64_t peak = session.volumeBufferCounters().peak_bytes +
                                session.textureBufferCounters().peak_bytes;
          EXPECT_LE(peak, least);
        }
}

TEST_F(SessionTest, smallBudgetsEvictAndGiveTheSamePicture) {
  const auto source = blobs();
  CountingSource counting(*source);
  RenderScene roomy(device(), *source, someTransfer(), {.block_vox = 8});
  const FloatPicture expected = roomy.draw(smallView());
  RenderScene scene(device(), counting, someTransfer(),
                    {.block_vox = 8, .pages = 8, .memory_bytes = 8 * 512 + (uint64_t{9} << 20)});
  EXPECT_TRUE(within(0.1, scene.draw(smallView()), expected));
  counting.reset();
  EXPECT_TRUE(within(0.1, scene.draw(smallView(180)), roomy.draw(smallView(180))));
  EXPECT_GT(scene.session().textureCache().counters().evictions, 0U);
  EXPECT_GT(scene.session().textureCache().counters().redundant_loads, 0U);
}

TEST_F(SessionTest, memoryIsSharedOutWithoutRest) {
  const PageGeometry page{{8, 8, 8}, 2, 8};
  constexpr uint64_t kMemory = uint64_t{1} << 30;
  const Budgets software = shareMemory(kMemory, page, TexelPlace::kInMemory, {16}, 2);
  EXPECT_EQ(software.texture_cache, 8U * 1024);
  EXPECT_EQ(software.volume_buffer + software.texture_buffer + software.texture_cache +
                software.scratch + spareTextureBytes(0),
            kMemory);
  const Budgets hardware = shareMemory(kMemory, page, TexelPlace::kOnDevice,
                                       {.block_vox = 16, .growing_bytes = 40'000}, 2);
  EXPECT_GT(hardware.boxes, 0U);
  EXPECT_GE(hardware.growing, static_cast<uint64_t>(hardware.readers + 1) * 40'000);
  EXPECT_EQ(hardware.volume_buffer + hardware.texture_buffer + hardware.scratch + hardware.boxes +
                hardware.growing,
            kMemory)
      << "textures have a memory of their own";
  const Budgets packed = shareMemory(kMemory, page, TexelPlace::kOnDevice, {16, 3 << 20}, 2);
  EXPECT_EQ(packed.volume_buffer + packed.texture_buffer + packed.scratch + packed.source, kMemory);
  const Budgets borrowed = shareMemory(kMemory, page, TexelPlace::kBorrowed, {16}, 2);
  // Each page has 2^3 bricks: two texels and a byte for each, and four bytes for the chunk.
  constexpr uint64_t kTables = 8 * (8 * (2 * 2 + 1) + 4);
  EXPECT_EQ(borrowed.volume_buffer + borrowed.texture_buffer + borrowed.scratch + kTables, kMemory)
      << "what is borrowed is counted once";
  EXPECT_EQ(borrowed.borrowed, 8U * 1024);
  EXPECT_GE(packed.source, static_cast<uint64_t>(packed.readers + 1) * (3 << 20));
}

// Level 2's counts of its reads equal those of the source.
TEST_F(SessionTest, volumeBufferReadsEachBlockOnceWhileItFits) {
  const auto source = blobs();
  CountingSource counting(*source);
  RenderScene scene(device(), counting, someTransfer(), {.block_vox = 8});
  counting.reset();  // the index read everything
  for (const Algorithm algorithm : kAlgorithms) {
    FrameOptions options = smallView();
    options.algorithm = algorithm;
    scene.frame(options);
  }
  const CacheCounters counters = scene.session().volumeBufferCounters();
  EXPECT_EQ(counters.redundant_loads, 0U);
  EXPECT_EQ(counters.loads, static_cast<uint64_t>(scene.ranges().layout.blockCount()));
  EXPECT_EQ(counters.decoded_bytes, static_cast<uint64_t>(counting.counts().bytes));
}

}  // namespace
}  // namespace sluice
