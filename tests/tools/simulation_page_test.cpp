#include "tools/pages/simulation_page.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tests/cache/simulate/turntable.h"

namespace sluice {
namespace {

std::string pageOf(const SimulationReport& report) {
  return simulationPage({&report, 1});
}

// The first "x y" of each path, text and rectangle, as the SVG has it.
TEST(SimulationPage, plotsStayWithinTheirPictures) {
  const std::regex place("(?: x='|[ML])(-?[0-9.]+)(?:' y='| )(-?[0-9.]+)");
  for (const uint64_t pages : {16, 256, 4096}) {
    const std::string html = pageOf(reportOf(turntable(), pages));
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

size_t countOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(SimulationPage, drawsALineAndPointsAtTheSizesForEveryPolicy) {
  const SimulationReport report = reportOf(turntable(), 256);
  const std::string html = pageOf(report);
  const size_t from = html.find("<svg"), to = html.find("</svg>", from);
  const std::string plot = html.substr(from, to - from);
  std::map<PolicyKind, size_t> sizes;
  for (const SimulationRow& row : report.rows) ++sizes[row.policy];
  EXPECT_EQ(sizes.size(), onlinePolicies().size() + 2);
  EXPECT_EQ(countOf(plot, "<path class='run "), sizes.size());
  EXPECT_EQ(countOf(plot, "<path class='point "), report.rows.size());
  EXPECT_EQ(countOf(plot, "class='curve' fill=none"), 1u);
  const std::string legend = html.substr(to, html.find("</p>", to) - to);
  for (const PolicyKind kind : onlinePolicies())
    EXPECT_NE(legend.find("</svg>" + std::string(name(kind)) + "</span>"), std::string::npos)
        << name(kind);
  EXPECT_NE(legend.find("belady-pages: the optimum"), std::string::npos);
}

TEST(SimulationPage, showsSeveralTracesOneAfterTheOther) {
  std::vector<SimulationReport> reports{reportOf(turntable(), 256), reportOf(turntable(), 64)};
  reports[1].title = "other";
  const std::string html = simulationPage(reports);
  EXPECT_EQ(countOf(html, "Miss ratio by cache size"), 2u);
  EXPECT_NE(html.find("<h2>other</h2>"), std::string::npos);
  EXPECT_NE(html.find("2 runs"), std::string::npos);
}

TEST(SimulationPage, marksRowsWhoseRequestsDidNotFit) {
  Trace trace = turntable();
  EXPECT_EQ(pageOf(reportOf(trace, 256)).find("do not fit"), std::string::npos);
  trace.records.push_back({999, 5000, 0, 12, {5000 * 4096, 0, 0, 0}});
  const std::string html = pageOf(reportOf(trace, 256));
  EXPECT_NE(html.find("do not fit"), std::string::npos);
  EXPECT_NE(html.find("class='on failed'"), std::string::npos);
}

TEST(SimulationPage, standsAloneAndEscapesWhatItShows) {
  const SimulationReport report = reportOf(turntable(), 256);
  const std::string html = pageOf(report);
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

TEST(SimulationPage, ofAnEmptyTrace) {
  const std::string html = pageOf(reportOf({}, 4));
  EXPECT_NE(html.find("No requests."), std::string::npos);
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace sluice
