// Opacity functions of a series, made over all steps and kept as bytes that are believed only if
// they are whole and belong to the series.
#include "src/index/series_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/random_volume.h"
#include "tests/support/series_functions.h"

namespace sluice {
namespace {

TransferFunction ramp() {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{20, 0}, {180, 1}};
  return transfer;
}

std::unique_ptr<MemorySource> blobs(int64_t steps) {
  return makeSparseBlobs({.blobs = 9, .drift_vox = 2, .time_steps = steps});
}

struct Made {
  explicit Made(VolumeSource& source, SeriesPassOptions options = {}, int threads = 2,
                uint64_t memory_bytes = UINT64_MAX)
      : layout(blockLayout(source.layout().dims, 8, 0)),
        table(ramp(), deviceMap(source.layout()), {0, 255}),
        series(makeTestSeries(source, layout, table, options, threads, memory_bytes)),
        recipe{ramp(),
               layout,
               source.layout().time_steps,
               options.difference,
               options.part_cells,
               options.directions} {}
  KeptSeries kept() const {
    KeptSeries result{ramp(), {0, 255}, {}, series.report, *series.opacity};
    result.nonempty.assign(static_cast<size_t>(recipe.steps), 7);
    return result;
  }
  BlockLayout layout;
  OpacityTable table;
  TestSeries series;
  SeriesRecipe recipe;
};

void expectSame(const SeriesOpacity& a, const SeriesOpacity& b) {
  EXPECT_EQ(a.functions, b.functions);
  EXPECT_EQ(a.spans, b.spans);
  EXPECT_EQ(a.first_span, b.first_span);
  EXPECT_TRUE(std::ranges::equal(a.tree->bits(), b.tree->bits()));
}

TEST(SeriesFile, givesBackWhatWasWritten) {
  const auto source = blobs(6);
  const Made made(*source);
  const auto read = deserializeSeries(serialize(made.kept(), made.recipe), made.recipe);
  ASSERT_TRUE(read);
  expectSame(read->opacity, *made.series.opacity);
  EXPECT_EQ(read->report.coherent, made.series.report.coherent);
  EXPECT_EQ(read->device_range, (ValueRange{0, 255}));
}

TEST(SeriesFile, whatIsOfAnotherSeriesIsRefused) {
  const auto source = blobs(6);
  const Made made(*source);
  const auto bytes = serialize(made.kept(), made.recipe);
  SeriesRecipe other = made.recipe;
  other.transfer.opacities.back().opacity = 0.5;
  EXPECT_FALSE(deserializeSeries(bytes, other));
  EXPECT_TRUE(deserializeSeries(bytes, other, true)) << "any transfer function's";
  EXPECT_NE(seriesKey(*source, other).what, seriesKey(*source, made.recipe).what);
  other = made.recipe;
  other.steps = 5;
  EXPECT_FALSE(deserializeSeries(bytes, other));
  other = made.recipe;
  other.layout = blockLayout(source->layout().dims, 16, 0);
  EXPECT_FALSE(deserializeSeries(bytes, other));
  other = made.recipe;
  other.difference = 0.1;
  EXPECT_FALSE(deserializeSeries(bytes, other));
}

TEST(SeriesFile, damagedBytesAreRefusedOrMakeSense) {
  const auto source = blobs(3);
  const Made made(*source);
  const auto bytes = serialize(made.kept(), made.recipe);
  std::mt19937 random(1);
  for (size_t cut = 0; cut < bytes.size(); cut += 1 + bytes.size() / 300)
    EXPECT_FALSE(deserializeSeries(std::span(bytes).first(cut), made.recipe)) << cut;
  for (int i = 0; i < 2000; ++i) {
    auto damaged = bytes;
    damaged[random() % bytes.size()] ^= static_cast<std::byte>(1U << (random() % 8));
    const auto read = deserializeSeries(damaged, made.recipe);
    if (!read) continue;
    // Whatever its contents, asking it is safe.
    for (int64_t block = 0; block < read->opacity.blockCount(); ++block)
      for (int64_t step = 0; step < 3; ++step) {
        const auto at = static_cast<size_t>(read->opacity.functionAt(block, step));
        ASSERT_LT(at, read->opacity.functions.size());
        const size_t parts = read->opacity.functions[at].parts.size();
        ASSERT_TRUE(parts == 0 ||
                    parts == static_cast<size_t>(volume(read->opacity.partsOf(block).count())));
      }
  }
}

TEST(SeriesPass, thresholdsAndThreadsAndRunsGiveTheSameSpans) {
  const auto source = blobs(8);
  const Made one(*source, {.difference = 1e-3}, 1);
  const Made few(*source, {.difference = 1e-3}, 3, 1);
  expectSame(*one.series.opacity, *few.series.opacity);
  const Made none(*source, {.difference = 0});
  const Made all(*source, {.difference = 2});
  EXPECT_EQ(all.series.report.coherentShare(), 1);
  EXPECT_EQ(all.series.opacity->spans.size(),
            static_cast<size_t>(all.series.opacity->blockCount()));
  EXPECT_EQ(none.series.report.coherentShare(), 0);
  EXPECT_GT(none.series.opacity->spans.size(), one.series.opacity->spans.size());
  // Each step's own function is no less than its span's.
  for (int64_t block = 0; block < none.series.opacity->blockCount(); ++block)
    for (int64_t step = 0; step < 8; ++step) {
      const SeriesOpacity &own = *none.series.opacity, &fused = *one.series.opacity;
      EXPECT_GE(own.functions[static_cast<size_t>(own.functionAt(block, step))].floor,
                fused.functions[static_cast<size_t>(fused.functionAt(block, step))].floor);
    }
}

TEST(SeriesPass, holdsTwoRunsAWorkerHoweverManySteps) {
  const auto few = blobs(2), many = blobs(9);
  EXPECT_EQ(Made(*few).series.report.worker_bytes, Made(*many).series.report.worker_bytes);
  const Made least(*few, {}, 2, 1);
  // A block of 8 voxels a side: its bytes as read and converted, opacities and cubes twice.
  EXPECT_EQ(least.series.report.worker_bytes, 512U * 2 + 2 * (512 + 512) * 4);
}

TEST(SeriesPass, whatIsEmptyIsNotRead) {
  VolumeLayout layout;
  layout.dims = {33, 33, 33};
  layout.time_steps = 4;
  const auto source = makeMemorySource<uint8_t>(layout, [](int64_t x, int64_t y, int64_t z) {
    return x < 10 && y < 10 && z < 10 ? 100 + x : 3;
  });
  const BlockLayout blocks = blockLayout(layout.dims, 8, 0);
  const OpacityTable table(ramp(), deviceMap(source->layout()), {0, 255});
  const ExtinctionTable extinction(table);
  WorkerPool pool(1);
  ProgressMeter progress;
  std::vector<StepBlocks> steps;
  for (int64_t time = 0; time < 4; ++time)
    steps.emplace_back(buildSliceRanges(*source, time, blocks, {pool, progress}), extinction);
  EXPECT_EQ(steps[0].nonEmpty(), 8);
  const uint64_t before = source->storedBytesRead();
  makeSeriesOpacity(*source, blocks, steps, extinction, {}, {pool, progress});
  EXPECT_EQ(source->storedBytesRead() - before, 4U * 4 * 15 * 8 * 8) << "4 runs of two blocks";
}

}  // namespace
}  // namespace sluice
