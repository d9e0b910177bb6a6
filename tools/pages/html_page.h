// Building blocks of report pages: one HTML file, nothing loaded from outside, drawings as inline
// SVG, readable in light, in dark and on paper. Pure functions; parameters called text are escaped,
// those called html are not.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

// The text for use inside HTML or SVG: & < > " and ' become entities, control characters '?'.
std::string escapeHtml(std::string_view text);

// The whole page. Its style has colours as variables (--ink, --soft, --line, --axis, --paper,
// --on), classes of drawings (axis, grid, tick, note, label, key, wide, facts) and kHues classes of
// fills, h0 and so on. `style` is added to it.
std::string htmlPage(std::string_view title, std::string_view style, std::string_view body_html);
inline constexpr int kHues = 10;

// Bytes as they stand in an attribute: "data:image/png;base64,...".
std::string dataUri(std::string_view media_type, std::span<const std::byte> bytes);

// Text cells under their heads; the first column is aligned to the left, the others as numbers.
using HtmlRow = std::vector<std::string>;
std::string htmlTable(const HtmlRow& heads, std::span<const HtmlRow> rows);
// Two columns of text, without heads.
std::string htmlFacts(std::span<const std::array<std::string, 2>> facts);

// An entry of a legend: the fill of a hue and its meaning.
std::string htmlKey(int hue, std::string_view text);

// Bars under each other from one zero, each of parts one after another.
struct BarPart {
  double value = 0;  // at least 0
  int hue = 0;
  std::string hint;  // shows under the pointer
};
struct Bar {
  std::string label, end;  // before the bar and behind it
  std::vector<BarPart> parts;
};
std::string barsSvg(std::span<const Bar> bars);

}  // namespace sluice
