// How boxes fall onto the orthogonal opacity map, and which part of a box remains visible (Li 2003,
// sections 4.1 and 4.3). Pure functions, any thread.
//
// The map lies in a plane orthogonal to an axis of the volume. Its projection takes that plane's
// neighbours along the view: faces of a box which are parallel to the map stay rectangles, moved
// for a parallel view, moved and scaled for a perspective one. So a box covers the bounds of its
// two faces, and a rectangle of the map is taken back to either face as simply.
#pragma once

#include <optional>

#include "src/base/values/vec.h"
#include "src/visibility/occlusion/opacity_map.h"

namespace sluice {

// Positions with real coordinates, lo <= p < hi.
struct RealBox {
  Vec3d lo, hi;
};

// Place and viewpoint of the map, both in one space of positions (cells of a block, or index
// space).
struct MapProjection {
  int axis = 2;      // the axis that the map is orthogonal to
  int u = 0, v = 1;  // the axes along the map's x and y
  double plane = 0;  // the map's place on `axis`
  double u0 = 0, v0 = 0, u_scale = 1,
         v_scale = 1;  // map x = (position[u] - u0) * u_scale; v likewise
  bool parallel = true;
  Vec3d eye;  // parallel: the viewing direction; otherwise the eye
};

// The map of `side` pixels, on the face of the volume that is farthest along the view. It covers
// the volume's projection; for a perspective eye that is not in front of the whole volume, that
// face. `direction` is the viewing direction, which chooses the axis; `eye` is a perspective
// view's. Requires: direction not zero; the volume not empty on any axis; side >= 1.
MapProjection parallelMap(const RealBox& volume, Vec3d direction, int side);
MapProjection perspectiveMap(const RealBox& volume, Vec3d eye, Vec3d direction, int side);

// The rectangle that the box covers: the bounds of its front and its back face. Endless if the box
// reaches to a perspective eye or behind it: nothing is known to hide it.
MapRect project(const MapProjection& projection, const RealBox& box);

// The part of the box that may show in `visible`: its front and back faces are the bounds of the
// rectangle taken back to both (R_vp of the paper). nullopt: nothing, the box is culled.
std::optional<RealBox> clip(const MapProjection& projection, const RealBox& box,
                            const MapRect& visible);

}  // namespace sluice
