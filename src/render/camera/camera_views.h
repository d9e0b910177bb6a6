// Named views: the direction from which a camera looks before azimuth and elevation turn it.
//
// The front and the up direction follow from the meaning of a volume's world axes (WorldFrame), so
// that a picture is upright without options and never mirrored: x to the right, y up and z toward
// the viewer of each view form a right-handed system in the world. Pure functions.
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string_view>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

inline constexpr double kDegree = std::numbers::pi / 180;  // in radians

// kPlain looks along -z with +y up whatever the axes mean. The others are the front of the frame,
// turned and lifted. Left and right are a patient's if the frame knows patients, otherwise those of
// a viewer of the front.
enum class ViewName { kPlain, kFront, kBack, kLeft, kRight, kTop, kBottom, kThreeQuarter };

std::string_view name(ViewName view);  // "plain", "front", ...

// Unit directions in the world, right = cross(up, back).
struct ViewAxes {
  Vec3d right, up, back;  // back: from the target to the eye
};

// The front of a frame:
//   RAS, LPS      superior up, from anterior: the patient's left is on the right
//   picture rows  rows run down and x to the right, the first slice nearest
//   y up, none    +y up, along -z
// `up` replaces the up direction: the view is from the front if `up` allows it, else from below.
// Requires: the length of `up` is finite and above 0.
ViewAxes frontAxes(ViewName view, WorldFrame frame, const std::optional<Vec3d>& up);

// How far a named view is turned about up, to the viewer's right, and lifted from its front.
struct ViewTurn {
  double azimuth_deg = 0, elevation_deg = 0;
};
// The turn of a named view from the front of the frame.
ViewTurn turnOf(ViewName view, WorldFrame frame);

// The axes after a turn about up and a lift. At 90 degrees of elevation the front is below.
ViewAxes turned(const ViewAxes& front, ViewTurn turn);

}  // namespace sluice
