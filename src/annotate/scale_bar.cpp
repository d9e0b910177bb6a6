// The scale bar: a round length of the world, as long as it is in the picture.
#include <algorithm>
#include <cmath>

#include "src/annotate/labels.h"
#include "src/annotate/parts.h"

namespace sluice {
namespace {

constexpr double kMostOfTheWidth = 0.22;

double worldUnitsAPixel(const Annotations& annotations) {
  const View& view = annotations.view;
  double half_height = view.half_height;
  if (view.projection == Projection::kPerspective)
    half_height *= dot(annotations.target - view.eye, view.forward);
  return 2 * half_height / view.size.height;
}

}  // namespace

void drawScaleBar(Pen& pen, const Annotations& annotations) {
  const PictureSize size = annotations.view.size;
  const double unit = worldUnitsAPixel(annotations);
  if (!(unit > 0)) return;
  const double length = roundBelow(kMostOfTheWidth * size.width * unit);
  const double right = size.width - kFreeEms * pen.em(), left = right - length / unit;
  // The bar lies in the middle of a row of pixels, so that it is sharp.
  const double y = std::floor(size.height - kFreeEms * pen.em()) + 0.5, end = 0.3 * pen.em();
  pen.line({{left, y - end}, {left, y}, {right, y}, {right, y - end}}, 0.14 * pen.em(), pen.ink());
  std::string label = tickLabel(length, length) + " " + unitSymbol(annotations.unit);
  // Elsewhere it would be longer or shorter.
  if (annotations.view.projection == Projection::kPerspective) label += " at the centre";
  const double middle = std::min((left + right) / 2, right - pen.widthOf(label) / 2);
  pen.word({middle, y - 0.95 * pen.em()}, Anchor::kMiddle, label, pen.ink());
}

}  // namespace sluice
