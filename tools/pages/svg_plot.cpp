#include "tools/pages/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/pages/html_page.h"

namespace sluice {
namespace {

constexpr double kLeft = 72, kRight = 28, kTop = 30, kBottom = 46;  // pixels around the frame

double scaled(const SvgAxis& axis, double v) {
  if (!axis.is_log2) return (v - axis.lo) / (axis.hi - axis.lo);
  // Values below the axis would lie outside of the picture, and 0 has no logarithm.
  return (std::log2(std::max(v, axis.lo)) - std::log2(axis.lo)) /
         (std::log2(axis.hi) - std::log2(axis.lo));
}

std::string tickText(double v, bool is_power_of_two) {
  if (is_power_of_two && v >= 1024) {
    constexpr std::string_view kUnits[] = {"Ki", "Mi", "Gi", "Ti", "Pi"};
    size_t unit = 0;
    for (v /= 1024; v >= 1024 && unit + 1 < std::size(kUnits); ++unit) v /= 1024;
    return fmt::format("{:g}{}", v, kUnits[unit]);
  }
  if (v >= 1e9) return fmt::format("{:g}G", v / 1e9);
  if (v >= 1e6) return fmt::format("{:g}M", v / 1e6);
  if (v >= 1e4) return fmt::format("{:g}k", v / 1e3);
  return fmt::format("{:g}", v);
}

// About six round values within the axis; powers of two on a logarithmic one.
std::vector<double> ticksOf(const SvgAxis& axis) {
  std::vector<double> ticks;
  if (axis.is_log2) {
    // Rounding must not take away a tick at an end.
    const int lo = static_cast<int>(std::ceil(std::log2(axis.lo) - 1e-9));
    const int hi = static_cast<int>(std::floor(std::log2(axis.hi) + 1e-9));
    const int step = std::max(1, (hi - lo) / 8);
    for (int e = lo; e <= hi; e += step) ticks.push_back(std::exp2(e));
    return ticks;
  }
  const double raw = (axis.hi - axis.lo) / 6;
  const double magnitude = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * magnitude;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * magnitude >= raw) {
      step = factor * magnitude;
      break;
    }
  }
  for (int i = 0; i < 20; ++i) {
    const double v = (std::ceil(axis.lo / step) + i) * step;
    if (v > axis.hi * (1 + 1e-9)) break;
    ticks.push_back(v);
  }
  return ticks;
}

}  // namespace

std::string markerSvg(SvgMarker shape, double x_px, double y_px, std::string_view css,
                      std::string_view hint) {
  const auto path = [&]() -> std::string_view {
    switch (shape) {
      case SvgMarker::kCircle:
        return "m-3.4 0a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0 -6.8 0Z";
      case SvgMarker::kSquare:
        return "m-3 -3h6v6h-6Z";
      case SvgMarker::kDiamond:
        return "m0 -4.2l4.2 4.2l-4.2 4.2l-4.2 -4.2Z";
      case SvgMarker::kUp:
        return "m0 -4l3.8 6.8h-7.6Z";
      case SvgMarker::kDown:
        return "m0 4l3.8 -6.8h-7.6Z";
      case SvgMarker::kPlus:
        return "m-1.1 -3.8h2.2v2.7h2.7v2.2h-2.7v2.7h-2.2v-2.7h-2.7v-2.2h2.7Z";
      case SvgMarker::kCross:
        return "m0 -1.6l2.4 -2.4l1.6 1.6l-2.4 2.4l2.4 2.4l-1.6 1.6l-2.4 -2.4l-2.4 2.4l-1.6 -1.6"
               "l2.4 -2.4l-2.4 -2.4l1.6 -1.6Z";
    }
    return "";
  };
  return fmt::format("<path class='{}' d='M{:.1f} {:.1f}{}'><title>{}</title></path>", css, x_px,
                     y_px, path(), escapeHtml(hint));
}

SvgPlot::SvgPlot(double width_px, double height_px, SvgAxis x, SvgAxis y)
    : width_px_(width_px), height_px_(height_px), x_(std::move(x)), y_(std::move(y)) {
  drawTicks();
}

void SvgPlot::drawTicks() {
  const double x0 = kLeft, x1 = width_px_ - kRight, y0 = height_px_ - kBottom, y1 = kTop;
  for (const double v : ticksOf(x_)) {
    body_ += fmt::format("<text class=tick x='{:.1f}' y='{:.1f}' text-anchor=middle>{}</text>",
                         xPixel(v), y0 + 16, tickText(v, x_.is_log2));
    body_ += fmt::format("<path class=axis d='M{:.1f} {:.1f}v4'/>", xPixel(v), y0);
  }
  for (const double v : ticksOf(y_)) {
    body_ += fmt::format("<path class=grid d='M{:.1f} {:.1f}H{:.1f}'/>", x0, yPixel(v), x1);
    body_ += fmt::format("<text class=tick x='{:.1f}' y='{:.1f}' text-anchor=end>{}</text>", x0 - 6,
                         yPixel(v) + 4, tickText(v, y_.is_log2));
  }
  body_ += fmt::format("<path class=axis d='M{:.1f} {:.1f}H{:.1f}'/>", x0, y0, x1);
  body_ += fmt::format("<text class=label x='{:.1f}' y='{:.1f}' text-anchor=middle>{}</text>",
                       (x0 + x1) / 2, height_px_ - 10, escapeHtml(x_.label));
  body_ += fmt::format(
      "<text class=label text-anchor=middle transform='translate(14 {:.1f}) rotate(-90)'>{}</text>",
      (y0 + y1) / 2, escapeHtml(y_.label));
}

double SvgPlot::xPixel(double x) const {
  return kLeft + scaled(x_, x) * (width_px_ - kLeft - kRight);
}

double SvgPlot::yPixel(double y) const {
  return height_px_ - kBottom - scaled(y_, y) * (height_px_ - kTop - kBottom);
}

std::string SvgPlot::path(std::span<const Point> points) const {
  std::string out;
  for (const auto& [x, y] : points)
    out += fmt::format("{}{:.1f} {:.1f}", out.empty() ? "" : "L", xPixel(x), yPixel(y));
  return out;
}

void SvgPlot::line(std::span<const Point> points, std::string_view css, std::string_view hint) {
  if (points.empty()) return;
  body_ += fmt::format("<path class='{}' fill=none d='M{}'><title>{}</title></path>", css,
                       path(points), escapeHtml(hint));
}

void SvgPlot::marker(Point at, SvgMarker shape, std::string_view css, std::string_view hint) {
  body_ += markerSvg(shape, xPixel(at.first), yPixel(at.second), css,
                     fmt::format("{}: {:g}, {:.4g}", hint, at.first, at.second));
}

void SvgPlot::area(std::span<const Point> lower, std::span<const Point> upper, std::string_view css,
                   std::string_view hint) {
  if (lower.empty() || upper.empty()) return;
  const std::vector<Point> back(lower.rbegin(), lower.rend());
  body_ += fmt::format("<path class='{}' d='M{}L{}Z'><title>{}</title></path>", css, path(upper),
                       path(back), escapeHtml(hint));
}

void SvgPlot::mark(double x, std::string_view css, std::string_view label) {
  body_ += fmt::format("<path class='{}' d='M{:.1f} {:.1f}V{:.1f}'/>", css, xPixel(x), kTop,
                       height_px_ - kBottom);
  // The label stands within the picture, whatever the mark's place.
  const double share = scaled(x_, x);
  const std::string_view anchor = share < 0.2 ? "start" : share > 0.8 ? "end" : "middle";
  body_ += fmt::format("<text class=note x='{:.1f}' y='{:.1f}' text-anchor={}>{}</text>", xPixel(x),
                       kTop - 10, anchor, escapeHtml(label));
}

std::string SvgPlot::finish() const {
  return fmt::format(
      "<svg viewBox='0 0 {0:g} {1:g}' width='{0:g}' height='{1:g}' role=img>{2}</svg>", width_px_,
      height_px_, body_);
}

}  // namespace sluice
