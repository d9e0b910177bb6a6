#include "cache/simulate/simulation_report.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/cache/simulate/turntable.h"

namespace sluice::simulation_report_test {
namespace {

TEST(SimulationReport, sizesGoFromTheHeaviestChunkToEverything) {
  const PreparedTrace trace = prepare(turntable());
  const std::vector<uint64_t> sizes = defaultSizes(trace, 300);
  EXPECT_TRUE(std::is_sorted(sizes.begin(), sizes.end()));
  EXPECT_EQ(std::count(sizes.begin(), sizes.end(), 300u), 1);
  EXPECT_GE(sizes.front(), trace.heaviest);
  EXPECT_GE(sizes.back(), trace.distinct_pages);
}

TEST(SimulationReport, residencyAndPagesAreThoseOfTheChosenCache) {
  const SimulationReport report = reportOf(turntable(), 256);
  ASSERT_EQ(report.page_map.size(), 256u);
  const SimulationReport::Sample& last = report.residency.back();
  EXPECT_EQ(last.request, turntable().records.size());
  const auto taken = std::count_if(report.page_map.begin(), report.page_map.end(),
                                   [](ChunkId c) { return c != TextureCache::kNoChunk; });
  EXPECT_EQ(last.this_frame + last.earlier, static_cast<uint64_t>(taken));
  for (const SimulationReport::Sample& s : report.residency)
    EXPECT_LE(s.this_frame + s.earlier, 256u);
}

TEST(SimulationReport, pageMapIsThatOfTheTextureCache) {
  const Trace trace = turntable();
  for (const PolicyKind kind : {PolicyKind::kLru, PolicyKind::kRandom, PolicyKind::kArc}) {
    TextureCache cache(150, trace.page_bytes, makePolicy(kind, 150, 1));
    const TraceRecord* last = nullptr;
    for (const TraceRecord& r : trace.records) {
      if (last != nullptr && (last->cluster != r.cluster || last->frame != r.frame))
        cache.unpinAll();
      cache.request(r.chunk, r.pages, r.bytes.moved);
      cache.pin(r.chunk);
      last = &r;
    }
    SimulationConfig chosen{kind, 150};
    chosen.pin_clusters = true;
    const SimulationReport report = makeReport(prepare(trace), "t", {}, true, chosen);
    EXPECT_EQ(report.page_map, cache.pageMap()) << name(kind);
    EXPECT_EQ(report.residency.back().this_frame + report.residency.back().earlier,
              cache.usedPages());
  }
}

TEST(SimulationReport, ofACacheOfTwoToThe31PagesShowsTheFirst) {
  Trace trace;
  for (uint32_t i = 0; i < 3; ++i)
    trace.records.push_back({i, (1u << 31) - 1, i, 0, {uint64_t{1} << 40, 0, 0, 0}});
  const SimulationReport report =
      makeReport(prepare(trace), "t", {}, true, {PolicyKind::kLru, uint64_t{1} << 31});
  EXPECT_EQ(report.page_map, std::vector<ChunkId>(SimulationReport::kMostPagesShown, 2));
}

}  // namespace
}  // namespace sluice::simulation_report_test
