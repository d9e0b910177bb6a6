#include "tools/pages/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "src/base/files/file_kind.h"

namespace sluice {
namespace {

// Hues that people with limited colour vision can tell apart, and that stand out from light and
// dark alike.
constexpr std::string_view kStyle = R"(
:root{color-scheme:light dark;--ink:#1c2430;--soft:#4a5564;--line:#dfe4ea;--axis:#7b8794;--paper:#fff;--on:#fdf1ea}
@media (prefers-color-scheme:dark){:root{--ink:#e6eaf0;--soft:#a9b4c2;--line:#39424e;--axis:#8793a1;--paper:#161b22;--on:#3a2a20}}
@media print{:root{--ink:#000;--soft:#333;--line:#ccc;--axis:#666;--paper:#fff;--on:#eee}
 *{print-color-adjust:exact;-webkit-print-color-adjust:exact}h2,svg,img,table{break-inside:avoid}h2{break-after:avoid}details{display:none}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:1060px;margin:2em auto;padding:0 1em}
h1{font-size:1.5em;overflow-wrap:anywhere}h2{font-size:1.15em;margin-top:2em}p,figcaption{color:var(--soft)}
svg,img{max-width:100%;height:auto}figure{margin:1em 0}code,pre{overflow-wrap:anywhere;white-space:pre-wrap;font-size:13px}
.axis{stroke:var(--axis);fill:none}.grid{stroke:var(--line);fill:none}
.tick,.note{font-size:12px;fill:var(--soft)}.label{font-size:13px;fill:var(--ink)}
.key{margin-right:1.2em;white-space:nowrap;display:inline-block}.key svg{vertical-align:middle;margin-right:.35em}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}
td,th{padding:.15em .5em;text-align:right;white-space:nowrap;border-bottom:1px solid var(--line)}
.facts td{text-align:left;white-space:normal;overflow-wrap:anywhere;vertical-align:top}.facts td:first-child{white-space:nowrap;color:var(--soft)}
td:first-child,th:first-child{text-align:left}
.h0{fill:#2a78b8}.h1{fill:#e69f00}.h2{fill:#009e73}.h3{fill:#cc79a7}.h4{fill:#d55e00}
.h5{fill:#6a5acd}.h6{fill:#8a8f98}.h7{fill:#b3a100}.h8{fill:#56b4e9}.h9{fill:#a0522d}
)";

constexpr double kBarsWidth = 1000, kLineHeight = 26, kEndRoom = 110, kCharacter = 7.2;  // pixels

}  // namespace

std::string escapeHtml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        // Control characters are no valid HTML.
        out += static_cast<unsigned char>(c) < 32 ? '?' : c;
    }
  }
  return out;
}

std::string htmlPage(std::string_view title, std::string_view style, std::string_view body_html) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
      "<meta name='viewport' content='width=device-width'><meta name='generator' "
      "content='{4}'><title>{0}</title>"
      "<style>{1}{2}</style></head><body>\n<h1>{0}</h1>\n{3}"
      "</body></html>\n",
      escapeHtml(title), kStyle, style, body_html, softwareMark());
}

std::string dataUri(std::string_view media_type, std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out = fmt::format("data:{};base64,", media_type);
  out.reserve(out.size() + bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t there = std::min<size_t>(3, bytes.size() - i);
    uint32_t word = 0;
    for (size_t j = 0; j < 3; ++j)
      word = word << 8U | (j < there ? std::to_integer<uint32_t>(bytes[i + j]) : 0U);
    for (size_t j = 0; j < 4; ++j) out += j <= there ? kDigits[word >> (18 - 6 * j) & 63U] : '=';
  }
  return out;
}

std::string htmlTable(const HtmlRow& heads, std::span<const HtmlRow> rows) {
  std::string out = "<div class='wide'><table><thead><tr>";
  for (const std::string& head : heads) out += fmt::format("<th>{}</th>", escapeHtml(head));
  out += "</tr></thead><tbody>\n";
  for (const HtmlRow& row : rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += fmt::format("<td>{}</td>", escapeHtml(cell));
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string htmlFacts(std::span<const std::array<std::string, 2>> facts) {
  std::string out = "<table class='facts'><tbody>\n";
  for (const auto& [fact, value] : facts)
    out += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escapeHtml(fact), escapeHtml(value));
  return out + "</tbody></table>\n";
}

std::string htmlKey(int hue, std::string_view text) {
  return fmt::format(
      "<span class='key'><svg viewBox='0 0 10 10' width='10' height='10'><rect "
      "class='h{}' width='10' height='10'/></svg>{}</span>",
      hue % kHues, escapeHtml(text));
}

std::string barsSvg(std::span<const Bar> bars) {
  double most = 0;
  size_t letters = 0, end_letters = 0;
  for (const Bar& bar : bars) {
    double sum = 0;
    for (const BarPart& part : bar.parts) sum += part.value;
    most = std::max(most, sum);
    letters = std::max(letters, bar.label.size());
    end_letters = std::max(end_letters, bar.end.size());
  }
  const double left = std::min(kBarsWidth / 3, 16 + kCharacter * static_cast<double>(letters));
  const double end_room =
      std::clamp(8 + kCharacter * static_cast<double>(end_letters), kEndRoom, kBarsWidth / 3);
  const double scale = most > 0 ? (kBarsWidth - left - end_room) / most : 0;
  const double height = kLineHeight * static_cast<double>(bars.size()) + 4;
  std::string out =
      fmt::format("<svg viewBox='0 0 {0:g} {1:g}' width='{0:g}' height='{1:g}' role='img'>",
                  kBarsWidth, height);
  for (size_t i = 0; i < bars.size(); ++i) {
    const double y = kLineHeight * static_cast<double>(i) + 2;
    double x = left;
    out += fmt::format("<text class='label' x='{:.1f}' y='{:g}' text-anchor='end'>{}</text>",
                       left - 8, y + 16, escapeHtml(bars[i].label));
    for (const BarPart& part : bars[i].parts) {
      const double width = part.value * scale;
      if (width > 0)
        out += fmt::format(
            "<rect class='h{}' x='{:.1f}' y='{:g}' width='{:.2f}' height='20'><title>{}"
            "</title></rect>",
            part.hue % kHues, x, y, width, escapeHtml(part.hint));
      x += width;
    }
    out += fmt::format("<text class='tick' x='{:.1f}' y='{:g}'>{}</text>\n", x + 6, y + 15,
                       escapeHtml(bars[i].end));
  }
  return out + "</svg>\n";
}

}  // namespace sluice
