#include "src/render/camera/camera_views.h"

#include <cmath>

namespace sluice {
namespace {

// The turn at which three sides of an object show and its front still dominates.
constexpr ViewTurn kThreeQuarterTurn{30, 20};

constexpr std::array<std::string_view, 8> kNames = {"plain", "front", "back",   "left",
                                                    "right", "top",   "bottom", "three-quarter"};

bool knowsPatients(WorldFrame frame) {
  return frame == WorldFrame::kRas || frame == WorldFrame::kLps;
}

ViewAxes axesOf(Vec3d up, Vec3d back) {
  return {cross(up, back), up, back};
}

ViewAxes frontOf(WorldFrame frame) {
  switch (frame) {
    case WorldFrame::kRas:
      // RAS: x to the right, y to the front, z up: the front of a patient is seen from +y.
      return axesOf({0, 0, 1}, {0, 1, 0});
    case WorldFrame::kLps:
      // LPS: y points to the back.
      return axesOf({0, 0, 1}, {0, -1, 0});
    case WorldFrame::kPictureRows:
      // Rows of pictures go down, and slices away from the viewer.
      return axesOf({0, -1, 0}, {0, 0, -1});
    case WorldFrame::kNone:
    case WorldFrame::kYUp:
      break;
  }
  return axesOf({0, 1, 0}, {0, 0, 1});
}

}  // namespace

std::string_view name(ViewName view) {
  return kNames[static_cast<size_t>(view)];
}

ViewAxes frontAxes(ViewName view, WorldFrame frame, const std::optional<Vec3d>& up) {
  const ViewAxes front = frontOf(view == ViewName::kPlain ? WorldFrame::kNone : frame);
  if (!up) return front;
  const Vec3d new_up = normalized(*up);
  const double along = dot(front.back, new_up);
  // If up lies along the view, the whole is tipped over its right side.
  constexpr double kParallel = 1 - 1e-9;
  if (std::abs(along) > kParallel) return axesOf(new_up, front.up * (along > 0 ? -1.0 : 1.0));
  return axesOf(new_up, normalized(front.back - new_up * along));
}

ViewTurn turnOf(ViewName view, WorldFrame frame) {
  // The patient's left is on the right for a viewer of the front.
  const double left = knowsPatients(frame) ? 90 : -90;
  switch (view) {
    case ViewName::kPlain:
    case ViewName::kFront:
      break;
    case ViewName::kBack:
      return {180, 0};
    case ViewName::kLeft:
      return {left, 0};
    case ViewName::kRight:
      return {-left, 0};
    case ViewName::kTop:
      return {0, 90};
    case ViewName::kBottom:
      return {0, -90};
    case ViewName::kThreeQuarter:
      return kThreeQuarterTurn;
  }
  return {};
}

ViewAxes turned(const ViewAxes& front, ViewTurn turn) {
  const double azimuth = turn.azimuth_deg * kDegree, elevation = turn.elevation_deg * kDegree;
  const Vec3d level = front.right * std::sin(azimuth) + front.back * std::cos(azimuth);
  const Vec3d back = level * std::cos(elevation) + front.up * std::sin(elevation);
  const Vec3d up = front.up * std::cos(elevation) - level * std::sin(elevation);
  return {cross(up, back), up, back};
}

}  // namespace sluice
