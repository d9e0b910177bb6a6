#include "cache/report_html.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "cache/key_table.h"
#include "cache/svg_plot.h"
#include "src/base/bytes.h"

namespace sluice {
namespace {

constexpr std::string_view kStyle = R"(
body{font:15px/1.5 system-ui,sans-serif;color:#1c2430;background:#fff;max-width:900px;margin:2em auto;padding:0 1em}
h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}p{color:#4a5564}
svg{max-width:100%;height:auto}
.axis{stroke:#7b8794;fill:none}.grid{stroke:#e4e8ed;fill:none}
.tick,.note{font-size:12px;fill:#4a5564}.label{font-size:13px;fill:#1c2430}
.other{stroke:#b3bcc7;stroke-width:1.3}.lru{stroke:#2a78b8;stroke-width:2}.best{stroke:#1c2430;stroke-width:2.2;stroke-dasharray:6 3}
.chosen{stroke:#d1581b;stroke-width:2.4}.pick{fill:#d1581b}.mark{stroke:#d1581b;stroke-dasharray:2 3;fill:none}
.t-lru{fill:#2a78b8}.t-best{fill:#1c2430}.t-chosen{fill:#d1581b}
.now{fill:#2a78b8}.kept{fill:#b9d3e8}
.needed{fill:#2a78b8}.rounding{fill:#e0a43a}.extended{fill:#c2547a}.empty{fill:#9aa5b1}
.key{display:inline-block;width:.8em;height:.8em;margin:0 .35em 0 1em}
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums;display:block;overflow-x:auto}
td,th{padding:.15em .6em;text-align:right;white-space:nowrap;border-bottom:1px solid #e4e8ed}
td:first-child,th:first-child{text-align:left}tr.on{background:#fdf1ea}
)";

// A swatch of a legend.
std::string keyOf(std::string_view css, std::string_view text) {
  return fmt::format(
      "<span><svg class=key viewBox='0 0 8 8'><rect class='{}' width=8 height=8 /></svg>{}</span>",
      css, text);
}

double missRatio(const SimulationRow& row) {
  return row.requests == 0 ? 1
                           : static_cast<double>(row.misses) / static_cast<double>(row.requests);
}

std::string missRatioPlot(const SimulationReport& report) {
  double lo = static_cast<double>(report.chosen_pages), hi = lo;
  std::map<PolicyKind, std::vector<SvgPlot::Point>> curves;
  for (const SimulationRow& row : report.rows) {
    const auto pages = static_cast<double>(row.pages);
    lo = std::min(lo, pages);
    hi = std::max(hi, pages);
    curves[row.policy].emplace_back(pages, missRatio(row));
  }
  if (hi <= lo) hi = 2 * lo;
  SvgPlot plot(860, 380, {lo, hi, true, "cache size, pages"}, {0, 1, false, "miss ratio of pages"});
  plot.mark(static_cast<double>(report.chosen_pages), "mark",
            fmt::format("chosen: {} pages", report.chosen_pages));
  // LRU at every size: the staircase, thinned to what a pixel shows.
  std::vector<SvgPlot::Point> stairs;
  for (double e = std::log2(lo); e <= std::log2(hi) + 1e-9; e += (std::log2(hi / lo)) / 600) {
    const auto pages = static_cast<uint64_t>(std::exp2(e) + 1e-6);
    stairs.emplace_back(std::exp2(e), report.lru.missRatioAt(pages));
  }
  for (const auto& [policy, points] : curves) {
    if (policy != report.chosen_policy && policy != PolicyKind::kBeladyPages)
      plot.line(points, "other", name(policy));
  }
  plot.line(stairs, "lru", "lru at every size");
  const auto drawn = [&](PolicyKind policy, std::string_view css) {
    const auto found = curves.find(policy);
    if (found != curves.end()) plot.line(found->second, css, name(policy));
  };
  drawn(PolicyKind::kBeladyPages, "best");
  drawn(report.chosen_policy, "chosen");
  for (const auto& [policy, points] : curves) {
    for (const SvgPlot::Point& p : points) {
      if (p.first == static_cast<double>(report.chosen_pages) && policy == report.chosen_policy)
        plot.dots({&p, 1}, "pick", name(policy));
    }
  }
  const auto line_key = [](std::string_view css, std::string_view text) {
    return fmt::format(
        "<span><svg viewBox='0 0 26 8' width=26 height=8 style='margin:0 .35em 0 1em'>"
        "<path class='{}' d='M0 4H26'/></svg>{}</span>",
        css, text);
  };
  return plot.finish() + "<p>" +
         line_key("chosen", fmt::format("{} (chosen)", name(report.chosen_policy))) +
         line_key("best", "optimum: no policy moves fewer pages") +
         line_key("lru", "lru at every size") + line_key("other", "other policies") + "</p>";
}

std::string residencyPlot(const SimulationReport& report) {
  if (report.residency.empty()) return "<p>No requests.</p>";
  const auto last = static_cast<double>(report.residency.back().request);
  SvgPlot plot(860, 260, {0, std::max(last, 1.0), false, "chunk requests"},
               {0, static_cast<double>(report.chosen_pages), false, "pages resident"});
  std::vector<SvgPlot::Point> zero, now, all;
  for (const SimulationReport::Sample& s : report.residency) {
    const auto x = static_cast<double>(s.request);
    zero.emplace_back(x, 0);
    now.emplace_back(x, static_cast<double>(s.this_frame));
    all.emplace_back(x, static_cast<double>(s.this_frame + s.earlier));
  }
  plot.area(zero, now, "now", "requested in the current frame");
  plot.area(now, all, "kept", "kept from earlier frames");
  return plot.finish() + "<p>" + keyOf("now", "requested in the current frame") +
         keyOf("kept", "kept from earlier frames") + "</p>";
}

// A square a page in order of page numbers; one color a chunk, adjacent ones told apart by hue.
std::string pageMapPicture(const SimulationReport& report) {
  constexpr size_t kMostPages = 4096;
  const size_t shown = std::min(report.page_map.size(), kMostPages);
  const size_t columns = shown <= 256 ? 32 : 64;
  const double cell = 832.0 / static_cast<double>(columns);
  const size_t lines = (shown + columns - 1) / columns;
  std::string out = fmt::format("<svg viewBox='0 0 860 {0:g}' width=860 height='{0:g}'>",
                                static_cast<double>(lines) * cell + 4);
  for (size_t page = 0; page < shown; ++page) {
    const ChunkId chunk = report.page_map[page];
    const uint64_t mixed = mixBits(chunk);
    const std::string fill = chunk == TextureCache::kNoChunk
                                 ? "#fff"
                                 : fmt::format("hsl({} {}% {}%)", mixed % 360,
                                               45 + mixed / 360 % 20, 55 + mixed / 7200 % 20);
    const size_t column = page % columns;
    const size_t line = page / columns;
    out += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}' stroke='#e4e8ed'>"
        "<title>page {}: {}</title></rect>",
        2 + static_cast<double>(column) * cell, 2 + static_cast<double>(line) * cell, cell - 1,
        cell - 1, fill, page,
        chunk == TextureCache::kNoChunk ? "free" : fmt::format("chunk {}", chunk));
  }
  out += "</svg>";
  if (shown < report.page_map.size())
    out += fmt::format("<p>The first {} of {} pages.</p>", shown, report.page_map.size());
  return out;
}

std::string bytesByCause(const SimulationReport& report) {
  uint64_t most = 1;
  std::vector<const SimulationRow*> rows;
  for (const SimulationRow& row : report.rows) {
    if (row.pages != report.chosen_pages) continue;
    rows.push_back(&row);
    most = std::max(most, row.bytes.moved);
  }
  std::string out =
      fmt::format("<svg viewBox='0 0 860 {0}' width=860 height={0}>", rows.size() * 26 + 4);
  for (size_t i = 0; i < rows.size(); ++i) {
    const LoadBytes& b = rows[i]->bytes;
    const auto y = static_cast<double>(i * 26 + 2);
    out += fmt::format("<text class=label x=96 y='{:g}' text-anchor=end>{}</text>", y + 16,
                       name(rows[i]->policy));
    double x = 104;
    const auto bar = [&](uint64_t bytes, std::string_view css) {
      const double width = 640.0 * static_cast<double>(bytes) / static_cast<double>(most);
      if (bytes == 0) return;
      out += fmt::format(
          "<rect class='{}' x='{:.1f}' y='{:g}' width='{:.1f}' height=20><title>{}: "
          "{}</title></rect>",
          css, x, y, std::max(width - 1, 0.3), css, formatBytes(bytes));
      x += width;
    };
    bar(b.needed, "needed");
    bar(b.rounding(), "rounding");
    bar(b.extended, "extended");
    bar(b.empty, "empty");
    out += fmt::format("<text class=tick x='{:.1f}' y='{:g}'>{}</text>", x + 6, y + 15,
                       formatBytes(b.moved));
  }
  return out + "</svg><p>" + keyOf("needed", "needed") + keyOf("rounding", "page rounding") +
         keyOf("extended", "extended parts of merges") + keyOf("empty", "retained empty voxels") +
         "</p>";
}

std::string rowsTable(const SimulationReport& report) {
  std::string out =
      "<table><tr><th>policy<th>pages<th>requests<th>hits<th>misses<th>miss ratio<th>compulsory"
      "<th>capacity<th>conflict<th>moved<th>needed<th>seconds</tr>";
  for (const SimulationRow& r : report.rows) {
    const bool chosen = r.policy == report.chosen_policy && r.pages == report.chosen_pages;
    out += fmt::format(
        "<tr{}><td>{}<td>{}<td>{}<td>{}<td>{}<td>{:.4f}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{:.4g}</"
        "tr>",
        chosen ? " class=on" : "", name(r.policy), r.pages, r.requests, r.hits, r.misses,
        missRatio(r), r.compulsory, r.capacity, r.conflict, formatBytes(r.bytes.moved),
        formatBytes(r.bytes.needed), r.modelled_seconds);
  }
  return out + "</table>";
}

}  // namespace

std::string htmlReport(const SimulationReport& report) {
  const std::string title = escapeHtml(report.title);
  std::string out = fmt::format(
      "<!doctype html><html lang=en><meta charset=utf-8><title>{0}</title><style>{1}</style>"
      "<h1>Texture cache: {0}</h1><table>",
      title, kStyle);
  for (const auto& [fact, value] : report.facts)
    out += fmt::format("<tr><td>{}<td>{}</tr>", escapeHtml(fact), escapeHtml(value));
  out += "</table><h2>Miss ratio by cache size</h2>" + missRatioPlot(report);
  out += "<h2>Residency over time</h2>" + residencyPlot(report);
  out +=
      "<h2>How chunks lie in pages</h2><p>At the end of the trace; a square a page, a color a "
      "chunk, white where free.</p>" +
      pageMapPicture(report);
  out += fmt::format("<h2>Bytes by cause at {} pages</h2>", report.chosen_pages) +
         bytesByCause(report);
  out += "<h2>All rows</h2>" + rowsTable(report);
  return out + "</html>\n";
}

}  // namespace sluice
