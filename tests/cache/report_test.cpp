#include <gtest/gtest.h>

#include <fstream>

#include "cache/random.h"
#include "cache/report_html.h"
#include "cache/simulation_report.h"

namespace sluice {
namespace {

// A turntable: 24 clusters of a few chunks, the order turning round half way.
Trace turntable() {
  Trace trace;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    for (uint32_t i = 0; i < 24; ++i) {
      const uint32_t cluster = frame < 6 ? i : 23 - i;
      for (uint32_t c = 0; c < 1 + cluster % 5; ++c) {
        TraceRecord r{cluster * 8 + c, 8 + (cluster * 7 + c * 5) % 40, cluster, frame, {}};
        r.bytes.moved = r.pages * trace.page_bytes;
        r.bytes.needed = r.bytes.moved / 2;
        r.bytes.extended = r.bytes.moved / 8;
        r.bytes.empty = r.bytes.moved / 4;
        trace.records.push_back(r);
      }
    }
  }
  return trace;
}

SimulationReport reportOf(const Trace& trace, uint64_t pages) {
  std::vector<PolicyKind> policies(onlinePolicies().begin(), onlinePolicies().end());
  policies.push_back(PolicyKind::kBelady);
  policies.push_back(PolicyKind::kBeladyPages);
  return makeReport(trace, "<turn & table>", policies, defaultSizes(prepare(trace), pages),
                    {PolicyKind::kLru, pages});
}

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

TEST(HtmlReport, standsAloneAndEscapesWhatItShows) {
  const SimulationReport report = reportOf(turntable(), 256);
  const std::string html = htmlReport(report);
  EXPECT_EQ(html.find("<turn"), std::string::npos);
  EXPECT_NE(html.find("&lt;turn &amp; table&gt;"), std::string::npos);
  for (const char* outside : {"http:", "https:", "src=", "href=", "@import", "url(", "<script"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  for (const char* part : {"Miss ratio by cache size", "chosen: 256 pages", "optimum",
                           "Residency over time", "How chunks lie in pages", "Bytes by cause"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  size_t squares = 0;
  for (size_t at = html.find("<title>page "); at != std::string::npos;
       at = html.find("<title>page ", at + 1))
    ++squares;
  EXPECT_EQ(squares, 256u);
  EXPECT_EQ(html.find("nan"), std::string::npos);
  EXPECT_EQ(html.find("inf"), std::string::npos);
}

TEST(HtmlReport, ofAnEmptyTrace) {
  const std::string html = htmlReport(reportOf({}, 4));
  EXPECT_NE(html.find("No requests."), std::string::npos);
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace sluice
