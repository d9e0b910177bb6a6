// Gestures of a camera: from a view and a movement of the hand to the next view. Pure functions.
//
// Views are placed (ViewOptions::look_at and up are set). Pixels are counted from the upper left
// corner of the pane, to the right and down; world positions are the volume's.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include <array>
#include <optional>

#include "src/base/values/vec.h"

namespace sluice {

// The properties of a volume that gestures need.
struct Ground {
  Vec3d center;       // center of the sphere around its outer voxels, world
  double radius = 1;  // radius of that sphere
  double finest_spacing = 1;
};
Ground groundOf(const VolumeInfo& info);

struct Pane {
  int width = 1, height = 1;  // pixels
};

// Right, up, back (from the target to the eye): unit directions of the world.
struct PlacedAxes {
  Vec3d right, up, back;
};
PlacedAxes axesOf(const ViewOptions& view);
// World units of a pixel at the target's depth.
double worldPerPixel(const ViewOptions& view, Pane pane, const Ground& ground);
// The world position under a pixel at the target's depth.
Vec3d worldAt(const ViewOptions& view, double x, double y, Pane pane, const Ground& ground);
struct PanePoint {
  double x = 0, y = 0;
};
// The point of the pane at which a world position is seen; nullopt: behind a perspective eye.
std::optional<PanePoint> paneOf(const ViewOptions& view, Vec3d world, Pane pane,
                                const Ground& ground);

// Turns about the target: half a turn for a drag across the shorter side. The volume follows the
// hand.
ViewOptions orbit(const ViewOptions& view, double dx, double dy, Pane pane);
// Moves the camera to the right about the vertical of the view, through the target.
ViewOptions turn(const ViewOptions& view, double degrees);
// Moves the visible things along with the hand.
ViewOptions pan(const ViewOptions& view, double dx, double dy, Pane pane, const Ground& ground);
// The point under the pixel at the target's depth stays there and grows by `factor` (above 0): a
// parallel view zooms; in a perspective view the eye comes nearer.
ViewOptions zoomTo(const ViewOptions& view, double factor, double x, double y, Pane pane,
                   const Ground& ground);
// Turns the picture; positive: the volume turns to the right.
ViewOptions roll(const ViewOptions& view, double degrees);
// Moves eye and target: by parts of the radius, along the view, to the right and up.
ViewOptions fly(const ViewOptions& view, double ahead, double right, double up,
                const Ground& ground);
// Turns the head: the eye keeps its place.
ViewOptions lookAround(const ViewOptions& view, double dx, double dy, Pane pane);
// Moves the position into the middle of the picture; sizes stay.
ViewOptions centerOn(const ViewOptions& view, Vec3d world);
// Things at the target's depth keep their size.
ViewOptions withProjection(const ViewOptions& view, ViewOptions::Projection projection, Pane pane,
                           const Ground& ground);

}  // namespace sluice
