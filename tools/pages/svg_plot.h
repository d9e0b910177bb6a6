// SvgPlot: a small drawing of axes, lines, areas and rectangles as inline SVG text. Coordinates
// given are data values on the plot's axes unless the name contains pixels. One thread.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sluice {

struct SvgAxis {
  double lo = 0, hi = 1;
  bool is_log2 = false;  // then lo > 0
  std::string label;
};

enum class SvgMarker { kCircle, kSquare, kDiamond, kUp, kDown, kPlus, kCross };
// The marker as SVG text with its middle at a pixel; `hint` shows under the pointer.
std::string markerSvg(SvgMarker shape, double x_px, double y_px, std::string_view css,
                      std::string_view hint);

class SvgPlot {
 public:
  using Point = std::pair<double, double>;

  // Draws frame, ticks and labels. Requires: axes with lo < hi.
  SvgPlot(double width_px, double height_px, SvgAxis x, SvgAxis y);

  // `css` is a class of the page's style sheet; `hint` shows under the pointer.
  void line(std::span<const Point> points, std::string_view css, std::string_view hint);
  void marker(Point at, SvgMarker shape, std::string_view css, std::string_view hint);
  // The area between two curves over the same x.
  void area(std::span<const Point> lower, std::span<const Point> upper, std::string_view css,
            std::string_view hint);
  // A vertical mark over the whole height with a label at its top.
  void mark(double x, std::string_view css, std::string_view label);
  // The whole <svg> element.
  std::string finish() const;

 private:
  double xPixel(double x) const;
  double yPixel(double y) const;
  std::string path(std::span<const Point> points) const;
  void drawTicks();

  const double width_px_, height_px_;
  const SvgAxis x_, y_;
  std::string body_;
};

}  // namespace sluice
