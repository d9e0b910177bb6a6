// The orientation axes: three arrows of the world's directions as the camera sees them.
#include <algorithm>
#include <array>
#include <cmath>

#include "src/annotate/parts.h"

namespace sluice {
namespace {

struct Axis {
  const char* label;
  Vec3d world;  // unit
  Vec3d rgb;
};

constexpr Vec3d kRed{0.9, 0.25, 0.2}, kGreen{0.25, 0.7, 0.25}, kBlue{0.25, 0.45, 0.95};

// The patient's right, front and head, whichever way the file counts.
std::array<Axis, 3> axesOfFrame(WorldFrame frame) {
  if (frame == WorldFrame::kRas)
    return {{{"R", {1, 0, 0}, kRed}, {"A", {0, 1, 0}, kGreen}, {"S", {0, 0, 1}, kBlue}}};
  if (frame == WorldFrame::kLps)
    return {{{"R", {-1, 0, 0}, kRed}, {"A", {0, -1, 0}, kGreen}, {"S", {0, 0, 1}, kBlue}}};
  return {{{"x", {1, 0, 0}, kRed}, {"y", {0, 1, 0}, kGreen}, {"z", {0, 0, 1}, kBlue}}};
}

void drawArrow(Pen& pen, Point from, Point along, const Axis& axis) {
  const double em = pen.em();
  const double length = std::hypot(along.x, along.y);
  const Point tip{from.x + along.x, from.y + along.y};
  pen.line({from, tip}, 0.16 * em, axis.rgb);
  // Toward or away from the eye: a dot, with its label next to it.
  const double head = std::min(0.5 * em, 0.6 * length);
  Point unit{0.7, -0.7};
  if (length > 0.2 * em) {
    unit = {along.x / length, along.y / length};
    const Point back{tip.x - unit.x * head, tip.y - unit.y * head};
    const Point side{-unit.y * 0.5 * head, unit.x * 0.5 * head};
    pen.line({{back.x + side.x, back.y + side.y}, tip, {back.x - side.x, back.y - side.y}},
             0.16 * em, axis.rgb);
  }
  pen.word({tip.x + 0.75 * em * unit.x, tip.y + 0.75 * em * unit.y}, Anchor::kMiddle, axis.label,
           axis.rgb);
}

}  // namespace

void drawOrientationAxes(Pen& pen, const Annotations& annotations) {
  const View& view = annotations.view;
  const double em = pen.em(), half = 0.5 * kAxesEms * em;
  const Point middle{kFreeEms * em + half, view.size.height - kFreeEms * em - half};
  std::array<Axis, 3> axes = axesOfFrame(annotations.frame);
  // Axes that point away come first, so that the others lie over them.
  std::sort(axes.begin(), axes.end(), [&](const Axis& a, const Axis& b) {
    return dot(a.world, view.forward) > dot(b.world, view.forward);
  });
  const double length = half - em;
  for (const Axis& axis : axes)
    drawArrow(pen, middle,
              {length * dot(axis.world, view.right), -length * dot(axis.world, view.up)}, axis);
}

}  // namespace sluice
