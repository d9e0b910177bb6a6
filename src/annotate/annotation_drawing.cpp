#include "src/annotate/annotation_drawing.h"

#include <algorithm>

#include "src/annotate/parts.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// A picture without a background is shown on white more often than not.
bool isLight(const std::optional<std::array<float, 3>>& background) {
  if (!background) return true;
  const auto& [r, g, b] = *background;
  return 0.3F * r + 0.59F * g + 0.11F * b > 0.5F;
}

}  // namespace

Picture drawAnnotations(const Picture& picture, const Annotations& annotations, int first_row) {
  const PictureSize size = annotations.view.size;
  SLUICE_CHECK_EQ(picture.width, size.width);
  SLUICE_CHECK_LE(first_row + picture.height, size.height);
  if (std::min(size.width, size.height) < kLeastAnnotatedPixels)
    failRequest("a picture of {} x {} pixels is too small for --annotate, which needs {} x {}",
                size.width, size.height, kLeastAnnotatedPixels, kLeastAnnotatedPixels);
  Pen pen(picture.width, picture.height, emOf(size), isLight(annotations.background), first_row);
  drawColorBar(pen, annotations);
  drawScaleBar(pen, annotations);
  drawOrientationAxes(pen, annotations);
  return pen.over(picture);
}

}  // namespace sluice
