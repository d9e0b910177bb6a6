#include "cache/report/report_html.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "cache/policies/key_table.h"
#include "src/base/bytes.h"
#include "src/report/html_page.h"
#include "src/report/svg_plot.h"

namespace sluice {
namespace {

// What the pages' common style does not have.
constexpr std::string_view kStyle = R"(
.curve{stroke:#8fb8dc;stroke-width:1.5;fill:none}.mark{stroke:#d1581b;stroke-dasharray:2 3;fill:none}
.lru{fill:#2a78b8}.fifo{fill:#e69f00}.clock{fill:#009e73}.random{fill:#999}.srrip{fill:#cc79a7}.twoq{fill:#6a4fb3}
.arc{fill:#d55e00}.s3fifo{fill:#7a5230}.sieve{fill:#b3a100}.belady{fill:#777f88}.best{fill:var(--ink)}
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
    PolicyLook{PolicyKind::kBelady, SvgMarker::kUp, "belady"},
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

double missRatio(const SimulationRow& row) {
  return row.requests == 0 ? 1
                           : static_cast<double>(row.misses) / static_cast<double>(row.requests);
}

// The sizes of the rows and the miss ratios, with room at the sides for markers beside each other.
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
    range.top = std::max(range.top, missRatio(row));
  }
  range.lo /= std::sqrt(2);
  range.hi *= std::sqrt(2);
  if (report.lru)
    range.top = std::max(range.top, report.lru->missRatioAt(static_cast<uint64_t>(range.lo)));
  range.top = std::min(1.0, std::ceil(range.top * 10 + 0.25) / 10);
  return range;
}

// LRU at every size: the staircase, thinned to what a pixel shows.
void drawCurve(const MissRatioCurve& curve, const PlotRange& range, SvgPlot& plot) {
  constexpr int kPoints = 700;
  std::vector<SvgPlot::Point> stairs;
  double before = 0;
  for (int i = 0; i <= kPoints; ++i) {
    const double pages = range.lo * std::pow(range.hi / range.lo, static_cast<double>(i) / kPoints);
    const double ratio = curve.missRatioAt(static_cast<uint64_t>(pages + 1e-6));
    if (i > 0 && ratio != before) stairs.emplace_back(pages, before);
    stairs.emplace_back(pages, ratio);
    before = ratio;
  }
  plot.line(stairs, "curve", "lru at every size");
}

// The rows by size.
using Columns = std::map<double, std::vector<const SimulationRow*>>;

// Pixels from one policy to the next in a column, so that columns stay apart.
double betweenPolicies(const Columns& columns, const SvgPlot& plot) {
  constexpr double kLeast = 2.2, kMost = 7, kShareOfColumn = 0.75;
  double between = kMost;
  for (auto column = columns.begin(); column != columns.end(); ++column) {
    const auto next = std::next(column);
    if (next == columns.end()) break;
    const double room = plot.pixelsBetween(column->first, next->first) * kShareOfColumn;
    between = std::min(between, room / static_cast<double>(kLooks.size()));
  }
  return std::max(between, kLeast);
}

// A column a size, where the policies stand side by side in the order of the legend: between two
// sizes nothing is known of them, so nothing joins them. Returns the legend.
std::string drawColumns(const SimulationReport& report, SvgPlot& plot) {
  Columns columns;
  for (const SimulationRow& row : report.rows)
    columns[static_cast<double>(row.pages)].push_back(&row);
  const double between = betweenPolicies(columns, plot);
  std::map<PolicyKind, std::string> legend;
  for (const auto& [pages, rows] : columns) {
    for (const SimulationRow* row : rows) {
      const SvgPlot::Point at{pages, missRatio(*row)};
      if (row->policy == PolicyKind::kBeladyPages) {
        plot.bar(at, between * static_cast<double>(kLooks.size()), "best", name(row->policy));
        legend[row->policy] = keyOf("<rect class=best y=4 width=26 height=2 />",
                                    "belady-pages: the optimum, no policy moves fewer pages");
      }
      for (size_t i = 0; i < kLooks.size(); ++i) {
        const PolicyLook& look = kLooks[i];
        if (look.kind != row->policy) continue;
        const bool chosen =
            row->policy == report.chosen_policy && row->pages == report.chosen_pages;
        const double aside =
            (static_cast<double>(i) - static_cast<double>(kLooks.size() - 1) / 2) * between;
        plot.marker(at, aside, look.shape, fmt::format("{}{}", look.css, chosen ? " chosen" : ""),
                    name(look.kind));
        legend[look.kind] =
            keyOf(markerSvg(look.shape, 13, 5, look.css, name(look.kind)), name(look.kind));
      }
    }
  }
  std::string text;
  for (const auto& [kind, entry] : legend) text += entry;
  return text;
}

std::string missRatioPlot(const SimulationReport& report) {
  const PlotRange range = rangeOf(report);
  SvgPlot plot(1000, 420, {range.lo, range.hi, true, "cache size, pages"},
               {0, range.top, false, "miss ratio of pages"});
  plot.mark(static_cast<double>(report.chosen_pages), "mark",
            fmt::format("chosen: {} pages", report.chosen_pages));
  if (report.lru) drawCurve(*report.lru, range, plot);
  std::string legend = drawColumns(report, plot);
  if (report.lru) legend += keyOf("<path class=curve d='M0 5H26'/>", "lru at every size");
  return plot.finish() + "<p>" + legend + "</p>";
}

std::string residencyPlot(const SimulationReport& report) {
  if (report.residency.empty()) return "<p>No requests.</p>";
  const auto last = static_cast<double>(report.residency.back().request);
  SvgPlot plot(1000, 260, {0, std::max(last, 1.0), false, "requests"},
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
                                static_cast<double>(lines) * cell + 4);
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

std::string rowsTable(const SimulationReport& report) {
  const bool is_planned = std::any_of(report.rows.begin(), report.rows.end(),
                                      [](const SimulationRow& r) { return r.planned_pages; });
  std::string out = fmt::format(
      "<div class=wide><table><tr><th>policy<th>pages{}<th>requests<th>hits<th>misses<th>miss ratio"
      "<th>compulsory<th>capacity<th>conflict<th>moved<th>needed<th>seconds<th>failed</tr>",
      is_planned ? "<th>planned for" : "");
  bool any_failed = false;
  for (const SimulationRow& r : report.rows) {
    const bool chosen = r.policy == report.chosen_policy && r.pages == report.chosen_pages;
    any_failed |= r.failures > 0;
    out += fmt::format("<tr class='{}{}'><td>{}<td>{}", chosen ? "on" : "",
                       r.failures > 0 ? " failed" : "", name(r.policy), r.pages);
    if (is_planned) out += fmt::format("<td>{}", r.planned_pages.value_or(0));
    out += fmt::format(
        "<td>{}<td>{}<td>{}<td>{:.4f}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{:.4g}<td>{}</tr>",
        r.requests, r.hits, r.misses, missRatio(r), r.compulsory, r.capacity, r.conflict,
        formatBytes(r.bytes.moved), formatBytes(r.bytes.needed), r.modelled_seconds,
        r.failures > 0 ? fmt::format("{}!", r.failures) : "0");
  }
  out += "</table></div>";
  if (any_failed)
    out +=
        "<p>! Requests that do not fit the cache: the renderer would stop there. Each costs its "
        "bytes every time.</p>";
  return out;
}

}  // namespace

std::string htmlReport(const SimulationReport& report) {
  std::vector<std::array<std::string, 2>> facts;
  for (const auto& [fact, value] : report.facts) facts.push_back({fact, value});
  std::string out = htmlFacts(facts);
  out += "<h2>Miss ratio by cache size</h2>" + missRatioPlot(report);
  out += "<h2>Residency over time</h2>" + residencyPlot(report);
  out +=
      "<h2>How chunks lie in pages</h2><p>At the end of the trace; a square a page, a color a "
      "chunk, empty where free.</p>" +
      pageMapPicture(report);
  out += fmt::format("<h2>Bytes by cause at {} pages</h2>", report.chosen_pages) +
         bytesByCause(report);
  out += "<h2>All rows</h2>" + rowsTable(report);
  return htmlPage("Texture cache: " + report.title, kStyle, out);
}

}  // namespace sluice
