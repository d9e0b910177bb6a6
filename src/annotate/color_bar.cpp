// The colour bar: the colours of the visible values, with some values next to them; for labels a
// patch each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/annotate/labels.h"
#include "src/annotate/parts.h"

namespace sluice {
namespace {

// The range from the lowest value that shows, or has a colour of its own, to the highest.
ValueRange shownRange(const TransferFunction& transfer, ValueRange all) {
  constexpr int kSamples = 4096;
  const double step = (all.hi - all.lo) / kSamples;
  ValueRange shown{all.hi, all.lo};
  for (int i = 0; i <= kSamples; ++i) {
    const double value = all.lo + i * step;
    if (!(opacityAt(transfer, value) > 0)) continue;
    shown.lo = std::min(shown.lo, value);
    shown.hi = std::max(shown.hi, value);
  }
  if (!(shown.lo <= shown.hi)) return all;
  // Beyond its last point a transfer function is constant: nothing is to be told apart there.
  if (transfer.colors.size() > 1) {
    const double last = std::max(transfer.colors.back().value, transfer.opacities.back().value);
    const double first = std::min(transfer.colors.front().value, transfer.opacities.front().value);
    const ValueRange told{std::max(shown.lo, first), std::min(shown.hi, last)};
    if (told.hi > told.lo) shown = told;
  }
  return shown.hi > shown.lo ? shown : all;
}

struct Place {
  double left, right, top, bottom;
};

Place placeOf(const Pen& pen, PictureSize size) {
  constexpr double kWidthEms = 0.9;
  const double em = pen.em(), right = size.width - kFreeEms * em;
  return {right - kWidthEms * em, right, 1.5 * kFreeEms * em,
          size.height - (kFreeEms + kScaleBarEms + 1) * em};
}

// A patch an entry, from the top on; if there is no room for all, the number of the others.
void drawLegend(Pen& pen, const Annotations& annotations) {
  const double em = pen.em(), row = 1.6 * em;
  const auto [left, right, top, bottom] = placeOf(pen, annotations.view.size);
  const size_t rows = std::max<size_t>(2, static_cast<size_t>((bottom - top) / row));
  const size_t all = annotations.legend.size(), shown = all <= rows ? all : rows - 1;
  for (size_t i = 0; i < shown; ++i) {
    const double y0 = std::round(top + static_cast<double>(i) * row), y1 = y0 + (right - left);
    const std::vector<Point> corners{{left, y0}, {right, y0}, {right, y1}, {left, y1}, {left, y0}};
    pen.line(corners, 0.1 * em, pen.ink());
    pen.area(corners, annotations.legend[i].rgb);
    pen.word({left - 0.6 * em, (y0 + y1) / 2}, Anchor::kRight, annotations.legend[i].text,
             pen.ink());
  }
  if (shown < all)
    pen.word({right, top + (static_cast<double>(shown) + 0.3) * row}, Anchor::kRight,
             fmt::format("{} more", all - shown), pen.ink());
}

}  // namespace

void drawColorBar(Pen& pen, const Annotations& annotations) {
  if (!annotations.legend.empty()) {
    drawLegend(pen, annotations);
    return;
  }
  const double em = pen.em();
  const auto [left, right, top, bottom] = placeOf(pen, annotations.view.size);
  const ValueRange range = shownRange(annotations.transfer, annotations.range);
  const double span = range.hi - range.lo;
  pen.line({{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}}, 0.1 * em,
           pen.ink());
  const int rows = static_cast<int>(std::round(bottom - top));
  for (int row = 0; row < rows; ++row) {
    const double share = 1 - (row + 0.5) / rows;
    const double value = range.lo + share * span, y = std::round(top) + row;
    // Values between those that show, or that the volume lacks, stay empty.
    if (!(opacityAt(annotations.transfer, value) > 0)) continue;
    const double x0 = std::round(left), x1 = std::round(right);
    pen.area({{x0, y}, {x1, y}, {x1, y + 1}, {x0, y + 1}}, colorAt(annotations.transfer, value));
  }
  const int count = std::clamp(static_cast<int>((bottom - top) / (3.2 * em)), 2, 7);
  const std::vector<double> values = ticks(range, count);
  const double step =
      values.size() > 1 ? values[1] - values[0] : std::max(std::abs(values[0]), 1.0);
  for (const double value : values) {
    const double share = span > 0 ? (value - range.lo) / span : 0.5;
    const double y = bottom - share * (bottom - top);
    pen.line({{left - 0.35 * em, y}, {left, y}}, 0.1 * em, pen.ink());
    pen.word({left - 0.6 * em, y}, Anchor::kRight, tickLabel(value, step), pen.ink());
  }
}

}  // namespace sluice
