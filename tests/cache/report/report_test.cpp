#include <gtest/gtest.h>

#include <cstdio>
#include <regex>
#include <string>

#include "cache/policies/random.h"
#include "cache/report/report_html.h"
#include "cache/simulate/simulation_report.h"

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
  const PreparedTrace prepared = prepare(trace);
  const SimulationConfig chosen{PolicyKind::kLru, pages};
  return makeReport(prepared, "<turn & table>",
                    simulateTable(prepared, policies, defaultSizes(prepared, pages), chosen), true,
                    chosen);
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

// The first "x y" of each path, text and rectangle, as the SVG has it.
TEST(HtmlReport, plotsStayWithinTheirPictures) {
  const std::regex place("(?: x='|[ML])(-?[0-9.]+)(?:' y='| )(-?[0-9.]+)");
  for (const uint64_t pages : {16, 256, 4096}) {
    const std::string html = htmlReport(reportOf(turntable(), pages));
    size_t places = 0;
    for (size_t at = html.find("<svg "); at != std::string::npos; at = html.find("<svg ", at + 1)) {
      double width = 0, height = 0;
      ASSERT_EQ(std::sscanf(html.c_str() + at, "<svg viewBox='0 0 %lf %lf'", &width, &height), 2);
      const std::string body = html.substr(at, html.find("</svg>", at) - at);
      for (std::sregex_iterator p(body.begin(), body.end(), place), end; p != end; ++p, ++places) {
        EXPECT_GE(std::stod((*p)[1]), 0) << p->str();
        EXPECT_LE(std::stod((*p)[1]), width) << p->str();
        EXPECT_GE(std::stod((*p)[2]), 0) << p->str();
        EXPECT_LE(std::stod((*p)[2]), height) << p->str();
      }
    }
    EXPECT_GT(places, 300u);
  }
}

// Nothing is known between two sizes but for LRU, whose curve is exact; so only it is a line.
TEST(HtmlReport, joinsNoSizesButByLrusCurveAndNamesEveryPolicy) {
  const std::string html = htmlReport(reportOf(turntable(), 256));
  const size_t from = html.find("<svg"), to = html.find("</svg>", from);
  const std::string plot = html.substr(from, to - from);
  size_t lines = 0;
  for (size_t at = plot.find("fill=none d="); at != std::string::npos;
       at = plot.find("fill=none d=", at + 1))
    ++lines;
  EXPECT_EQ(lines, 1u);
  EXPECT_NE(plot.find("class='curve' fill=none"), std::string::npos);
  const std::string legend = html.substr(to, html.find("</p>", to) - to);
  for (const PolicyKind kind : onlinePolicies())
    EXPECT_NE(legend.find("</svg>" + std::string(name(kind)) + "</span>"), std::string::npos)
        << name(kind);
  EXPECT_NE(legend.find("belady-pages: the optimum"), std::string::npos);
}

TEST(HtmlReport, marksRowsWhoseRequestsDidNotFit) {
  Trace trace = turntable();
  EXPECT_EQ(htmlReport(reportOf(trace, 256)).find("do not fit"), std::string::npos);
  trace.records.push_back({999, 5000, 0, 12, {5000 * 4096, 0, 0, 0}});
  const std::string html = htmlReport(reportOf(trace, 256));
  EXPECT_NE(html.find("do not fit"), std::string::npos);
  EXPECT_NE(html.find("class='on failed'"), std::string::npos);
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
