#include "tools/pages/simulation_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "cache/policies/key_table.h"
#include "src/base/values/bytes.h"
#include "tools/pages/html_page.h"
#include "tools/pages/svg_plot.h"

namespace sluice {
namespace {

// Styles in addition to the pages' common style.
constexpr std::string_view kPageStyle = R"(
.curve{stroke:#8fb8dc;stroke-width:4;opacity:.6;fill:none}.mark{stroke:#d1581b;stroke-dasharray:2 3;fill:none}
.run{stroke:var(--c);stroke-width:1.3;fill:none}.point{fill:var(--c)}
.lru{--c:#2a78b8}.fifo{--c:#e69f00}.clock{--c:#009e73}.random{--c:#999}.srrip{--c:#cc79a7}.twoq{--c:#6a4fb3}
.arc{--c:#d55e00}.s3fifo{--c:#7a5230}.sieve{--c:#b3a100}.lfu{--c:#00a0b0}.slru{--c:#c2185b}.wtinylfu{--c:#4caf50}
.lirs{--c:#3f51b5}.gdsf{--c:#ff7f6e}.belady{--c:#777f88}.best{--c:var(--ink)}
.chosen{stroke:var(--ink);stroke-width:1.4}
.now{fill:#2a78b8}.kept{fill:#b9d3e8}.free{fill:var(--paper)}.page{stroke:var(--line)}
tr.on{background:var(--on)}tr.failed td:last-child{color:#d0103a;font-weight:bold}
)";

// How a policy looks in a plot.
struct PolicyLook {
  PolicyKind kind;
  SvgMarker shape;
  std::string_view css;
};
constexpr std::array kLooks{
    PolicyLook{PolicyKind::kLru, SvgMarker::kCircle, "lru"},
    PolicyLook{PolicyKind::kFifo, SvgMarker::kSquare, "fifo"},
    PolicyLook{PolicyKind::kClock, SvgMarker::kDiamond, "clock"},
    PolicyLook{PolicyKind::kRandom, SvgMarker::kPlus, "random"},
    PolicyLook{PolicyKind::kSrrip, SvgMarker::kUp, "srrip"},
    PolicyLook{PolicyKind::kTwoQ, SvgMarker::kDown, "twoq"},
    PolicyLook{PolicyKind::kArc, SvgMarker::kCross, "arc"},
    PolicyLook{PolicyKind::kS3Fifo, SvgMarker::kSquare, "s3fifo"},
    PolicyLook{PolicyKind::kSieve, SvgMarker::kDiamond, "sieve"},
    PolicyLook{PolicyKind::kLfu, SvgMarker::kCircle, "lfu"},
    PolicyLook{PolicyKind::kSlru, SvgMarker::kUp, "slru"},
    PolicyLook{PolicyKind::kWTinyLfu, SvgMarker::kDown, "wtinylfu"},
    PolicyLook{PolicyKind::kLirs, SvgMarker::kPlus, "lirs"},
    PolicyLook{PolicyKind::kGdsf, SvgMarker::kCross, "gdsf"},
    PolicyLook{PolicyKind::kBelady, SvgMarker::kUp, "belady"},
    PolicyLook{PolicyKind::kBeladyPages, SvgMarker::kDown, "best"},
};

// An entry of a legend: `drawing` is SVG in a field of 26 by 10 pixels.
std::string keyOf(std::string_view drawing, std::string_view text) {
  return fmt::format(
      "<span class=key><svg viewBox='0 0 26 10' width=26 height=10>{}</svg>{}</span>", drawing,
      text);
}
std::string swatchOf(std::string_view css, std::string_view text) {
  return keyOf(fmt::format("<rect class='{}' x=8 width=10 height=10 />", css), text);
}

// The sizes of the rows and the miss ratios, with room at the sides for the markers.
struct PlotRange {
  double lo = 1, hi = 2;
  double top = 0.1;
};
PlotRange rangeOf(const SimulationReport& report) {
  PlotRange range;
  range.lo = range.hi = static_cast<double>(report.chosen_pages);
  for (const SimulationRow& row : report.rows) {
    range.lo = std::min(range.lo, static_cast<double>(row.pages));
    range.hi = std::max(range.hi, static_cast<double>(row.pages));
    range.top = std::max(range.top, row.missRatio());
  }
  range.lo /= std::sqrt(2);
  range.hi *= std::sqrt(2);
  if (report.lru)
    range.top = std::max(range.top, report.lru->missRatioAt(static_cast<uint64_t>(range.lo)));
  range.top = std::min(1.0, std::ceil(range.top * 10 + 0.25) / 10);
  return range;
}

// LRU at every size: the staircase, thinned to the resolution of pixels.
void drawCurve(const MissRatioCurve& curve, const PlotRange& range, SvgPlot& plot) {
  constexpr int kPoints = 700;
  std::vector<SvgPlot::Point> stairs;
  double before = 0;
  for (int i = 0; i <= kPoints; ++i) {
    const double pages = range.lo * std::pow(range.hi / range.lo, static_cast<double>(i) / kPoints);
    // Powers of two come out of pow() a little too small.
    const double ratio = curve.missRatioAt(static_cast<uint64_t>(pages + 1e-6));
    // A step stands upright instead of being joined by a slope.
    if (i > 0 && ratio != before) stairs.emplace_back(pages, before);
    stairs.emplace_back(pages, ratio);
    before = ratio;
  }
  plot.line(stairs, "curve", "lru at every size");
}

std::string textOf(PolicyKind kind) {
  return std::string(name(kind)) +
         (kind == PolicyKind::kBeladyPages ? ": the optimum, no policy moves fewer pages" : "");
}

// A line a policy, joined from size to size, with a marker at each size that was simulated. Returns
// the legend.
std::string drawPolicies(const SimulationReport& report, SvgPlot& plot) {
  std::string legend;
  for (const PolicyLook& look : kLooks) {
    std::map<double, const SimulationRow*> by_size;
    for (const SimulationRow& row : report.rows)
      if (row.policy == look.kind) by_size[static_cast<double>(row.pages)] = &row;
    if (by_size.empty()) continue;
    std::vector<SvgPlot::Point> points;
    points.reserve(by_size.size());
    for (const auto& [pages, row] : by_size) points.emplace_back(pages, row->missRatio());
    plot.line(points, fmt::format("run {}", look.css), name(look.kind));
    for (const auto& [pages, row] : by_size) {
      const bool chosen = row->policy == report.chosen_policy && row->pages == report.chosen_pages;
      plot.marker({pages, row->missRatio()}, look.shape,
                  fmt::format("point {}{}", look.css, chosen ? " chosen" : ""), name(look.kind));
    }
    const std::string css = fmt::format("point {}", look.css);
    legend += keyOf(fmt::format("<path class='run {}' d='M0 5H26'/>", look.css) +
                        markerSvg(look.shape, 13, 5, css, name(look.kind)),
                    textOf(look.kind));
  }
  return legend;
}

std::string missRatioPlot(const SimulationReport& report) {
  const PlotRange range = rangeOf(report);
  SvgPlot plot(1000, 420, {range.lo, range.hi, true, "cache size, pages"},
               {0, range.top, false, "miss ratio of pages"});
  plot.mark(static_cast<double>(report.chosen_pages), "mark",
            fmt::format("chosen: {} pages", report.chosen_pages));
  if (report.lru) drawCurve(*report.lru, range, plot);
  std::string legend = drawPolicies(report, plot);
  if (report.lru) legend += keyOf("<path class=curve d='M0 5H26'/>", "lru at every size, exact");
  return plot.finish() + "<p>" + legend + "</p>";
}

std::string residencyPlot(const SimulationReport& report) {
  if (report.residency.empty()) return "<p>No requests.</p>";
  const auto last = static_cast<double>(report.residency.back().request);
  SvgPlot plot(1000, 260, {0, std::max(last, 1.0), false, "chunk requests"},
               {0, static_cast<double>(report.chosen_pages), false, "pages resident"});
  std::vector<SvgPlot::Point> zero, now, all;
  for (const SimulationReport::Sample& s : report.residency) {
    const auto x = static_cast<double>(s.request);
    zero.emplace_back(x, 0);
    now.emplace_back(x, static_cast<double>(s.this_frame));
    all.emplace_back(x, static_cast<double>(s.this_frame + s.earlier));
  }
  if (!report.knows_frames) {
    plot.area(zero, all, "now", "resident");
    return plot.finish();
  }
  plot.area(zero, now, "now", "requested in the current frame");
  plot.area(now, all, "kept", "kept from earlier frames");
  return plot.finish() + "<p>" + swatchOf("now", "requested in the current frame") +
         swatchOf("kept", "kept from earlier frames") + "</p>";
}

// A square a page in order of page numbers; one color a chunk, adjacent ones told apart by hue.
std::string pageMapPicture(const SimulationReport& report) {
  const size_t shown = report.page_map.size();
  const size_t columns = shown <= 256 ? 32 : 64;
  const double cell = 996.0 / static_cast<double>(columns);
  const size_t lines = (shown + columns - 1) / columns;
  std::string out = fmt::format("<svg viewBox='0 0 1000 {0:g}' width=1000 height='{0:g}'>",
                                std::ceil(static_cast<double>(lines) * cell + 4));
  for (size_t page = 0; page < shown; ++page) {
    const ChunkId chunk = report.page_map[page];
    const uint64_t mixed = mixBits(chunk);
    const std::string fill = chunk == TextureCache::kNoChunk
                                 ? "class='page free'"
                                 : fmt::format("class=page fill='hsl({} {}% {}%)'", mixed % 360,
                                               45 + mixed / 360 % 20, 55 + mixed / 7200 % 20);
    const size_t column = page % columns;
    const size_t line = page / columns;
    out += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' {}>"
        "<title>page {}: {}</title></rect>",
        2 + static_cast<double>(column) * cell, 2 + static_cast<double>(line) * cell, cell - 1,
        cell - 1, fill, page,
        chunk == TextureCache::kNoChunk ? "free" : fmt::format("chunk {}", chunk));
  }
  out += "</svg>";
  if (shown < report.chosen_pages)
    out += fmt::format("<p>The first {} of {} pages.</p>", shown, report.chosen_pages);
  return out;
}

std::string bytesByCause(const SimulationReport& report) {
  constexpr int kNeeded = 0, kRounding = 1, kExtended = 3, kEmpty = 6;  // hues
  std::vector<Bar> bars;
  for (const SimulationRow& row : report.rows) {
    if (row.pages != report.chosen_pages) continue;
    const LoadBytes& b = row.bytes;
    Bar bar{std::string(name(row.policy)), formatBytes(b.moved), {}};
    const auto part = [&bar](uint64_t bytes, int hue, std::string_view cause) {
      bar.parts.push_back(
          {static_cast<double>(bytes), hue, fmt::format("{}: {}", cause, formatBytes(bytes))});
    };
    part(b.needed, kNeeded, "needed");
    part(b.rounding(), kRounding, "rounding to pages");
    part(b.extended, kExtended, "extended parts of merges");
    part(b.empty, kEmpty, "retained empty voxels");
    bars.push_back(std::move(bar));
  }
  return barsSvg(bars) + "<p>" + htmlKey(kNeeded, "needed") +
         htmlKey(kRounding, "rounding to pages") + htmlKey(kExtended, "extended parts of merges") +
         htmlKey(kEmpty, "retained empty voxels") + "</p>";
}

// `isChosen`: whether a row is marked.
template <class IsChosen>
std::string rowsTable(std::span<const SimulationRow> rows, const IsChosen& isChosen) {
  const bool is_planned =
      std::ranges::any_of(rows, [](const SimulationRow& r) { return r.planned_pages.has_value(); });
  std::string out = fmt::format(
      "<div class=wide><table><tr><th>policy<th>pages{}<th>miss ratio<th>page "
      "requests<th>hits<th>misses"
      "<th>compulsory<th>capacity<th>conflict<th>moved<th>needed<th>seconds<th>failed</tr>",
      is_planned ? "<th>planned for" : "");
  bool any_failed = false;
  for (const SimulationRow& r : rows) {
    any_failed |= r.failures > 0;
    out += fmt::format("<tr class='{}{}'><td>{}<td>{}", isChosen(r) ? "on" : "",
                       r.failures > 0 ? " failed" : "", name(r.policy), r.pages);
    if (is_planned) out += fmt::format("<td>{}", r.planned_pages.value_or(0));
    out += fmt::format(
        "<td>{:.4f}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{:.4g}<td>{}</tr>",
        r.missRatio(), r.requests, r.hits, r.misses, r.compulsory, r.capacity, r.conflict,
        formatBytes(r.bytes.moved), formatBytes(r.bytes.needed), r.modelled_seconds,
        r.failures > 0 ? fmt::format("{}!", r.failures) : "0");
  }
  out += "</table></div>";
  if (any_failed)
    out +=
        "<p>! Chunk requests that do not fit the cache: the renderer would stop there. Each costs "
        "its "
        "bytes every time.</p>";
  return out;
}

// The sections of a trace under headings of this level.
std::string sectionsOf(const SimulationReport& report, int level) {
  const auto heading = [level](const std::string& text) {
    return fmt::format("<h{0}>{1}</h{0}>", level, text);
  };
  std::vector<std::array<std::string, 2>> facts;
  for (const auto& [fact, value] : report.facts) facts.push_back({fact, value});
  std::string out = htmlFacts(facts);
  out += heading("Miss ratio by cache size") + missRatioPlot(report);
  out += heading("Residency over time") + residencyPlot(report);
  out += heading("How chunks lie in pages") +
         "<p>Pages at the end of the trace: one square per page, one color per chunk, empty if "
         "free.</p>" +
         pageMapPicture(report);
  out += heading(fmt::format("Bytes by cause at {} pages", report.chosen_pages)) +
         bytesByCause(report);
  return out + heading("All rows") + rowsTable(report.rows, [&](const SimulationRow& row) {
           return row.policy == report.chosen_policy && row.pages == report.chosen_pages;
         });
}

// A table for each page size.
std::string sumSections(std::span<const SimulationRow> sums) {
  std::string out;
  while (!sums.empty()) {
    const std::string& page = sums.front().page;
    const auto end =
        std::ranges::find_if(sums, [&](const SimulationRow& row) { return row.page != page; });
    const auto count = static_cast<size_t>(end - sums.begin());
    out += fmt::format("<h2>All channels together{}</h2>",
                       page.empty() ? "" : ", pages of " + escapeHtml(page)) +
           rowsTable(sums.first(count), [](const SimulationRow& /*row*/) { return false; });
    sums = sums.subspan(count);
  }
  return out;
}

}  // namespace

std::string simulationPage(std::span<const SimulationReport> reports,
                           std::span<const SimulationRow> sums) {
  if (reports.size() == 1)
    return htmlPage("Texture cache: " + reports[0].title, kPageStyle, sectionsOf(reports[0], 2));
  std::string out;
  for (const SimulationReport& report : reports)
    out += fmt::format("<h2>{}</h2>", escapeHtml(report.title)) + sectionsOf(report, 3);
  out += sumSections(sums);
  return htmlPage(fmt::format("Texture cache: {} runs", reports.size()), kPageStyle, out);
}

}  // namespace sluice
