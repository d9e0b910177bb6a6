#include "src/visibility/occlusion/box_occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/base/error.h"

namespace sluice {
namespace {

// A rectangle in the map's plane, in positions.
struct PlaneRect {
  double u0, v0, u1, v1;
};

PlaneRect unite(const PlaneRect& a, const PlaneRect& b) {
  return {std::min(a.u0, b.u0), std::min(a.v0, b.v0), std::max(a.u1, b.u1), std::max(a.v1, b.v1)};
}

// Maps a face at `at` on the map's axis to the map's plane: position * scale + offset.
struct FaceMap {
  double u_scale = 1, u_offset = 0, v_scale = 1, v_offset = 0;
};

bool isInFront(const MapProjection& map, double at) {
  // The map lies farther than everything, so that its side is the viewing one.
  return map.parallel || (map.plane > map.eye[map.axis]) == (at > map.eye[map.axis]);
}

// Requires: isInFront.
FaceMap faceMap(const MapProjection& map, double at) {
  // Parallel to the direction: a place moves sideways in proportion to its distance from the plane.
  if (map.parallel) {
    const double way = (map.plane - at) / map.eye[map.axis];
    return {1, way * map.eye[map.u], 1, way * map.eye[map.v]};
  }
  // By similar triangles about the eye.
  const double scale = (map.plane - map.eye[map.axis]) / (at - map.eye[map.axis]);
  return {scale, map.eye[map.u] * (1 - scale), scale, map.eye[map.v] * (1 - scale)};
}

PlaneRect ontoPlane(const MapProjection& map, const RealBox& box, double at) {
  const FaceMap face = faceMap(map, at);
  return {
      box.lo[map.u] * face.u_scale + face.u_offset, box.lo[map.v] * face.v_scale + face.v_offset,
      box.hi[map.u] * face.u_scale + face.u_offset, box.hi[map.v] * face.v_scale + face.v_offset};
}

PlaneRect fromPlane(const MapProjection& map, const PlaneRect& rect, double at) {
  const FaceMap face = faceMap(map, at);
  return {(rect.u0 - face.u_offset) / face.u_scale, (rect.v0 - face.v_offset) / face.v_scale,
          (rect.u1 - face.u_offset) / face.u_scale, (rect.v1 - face.v_offset) / face.v_scale};
}

bool isInFront(const MapProjection& map, const RealBox& box) {
  return isInFront(map, box.lo[map.axis]) && isInFront(map, box.hi[map.axis]);
}

// Distinct from the eye's own plane, which has no projection.
bool reachesEye(const MapProjection& map, const RealBox& box) {
  if (map.parallel) return false;
  const double eye = map.eye[map.axis];
  return !isInFront(map, box) || box.lo[map.axis] == eye || box.hi[map.axis] == eye ||
         map.plane == eye;
}

MapProjection makeMap(const RealBox& volume, bool parallel, Vec3d eye, Vec3d direction, int side) {
  SLUICE_CHECK_LE(1, side);
  MapProjection map;
  for (int a = 0; a < 3; ++a) {
    SLUICE_CHECK_LT(volume.lo[a], volume.hi[a]);
    if (std::abs(direction[a]) > std::abs(direction[map.axis])) map.axis = a;
  }
  SLUICE_CHECK(direction[map.axis] != 0);
  // The map lies across the axis that the view is most parallel to (Li 2003, section 4.1), so that
  // boxes project onto it as rectangles.
  map.u = map.axis == 0 ? 1 : 0;
  map.v = map.axis == 2 ? 1 : 2;
  map.plane = direction[map.axis] > 0 ? volume.hi[map.axis] : volume.lo[map.axis];
  map.parallel = parallel;
  map.eye = parallel ? direction : eye;
  PlaneRect covered{volume.lo[map.u], volume.lo[map.v], volume.hi[map.u], volume.hi[map.v]};
  // If the eye's plane cuts the volume, there is no projection: the map covers the volume's own
  // face, and all outside it is visible.
  if (!reachesEye(map, volume))
    covered = unite(ontoPlane(map, volume, volume.lo[map.axis]),
                    ontoPlane(map, volume, volume.hi[map.axis]));
  map.u0 = covered.u0;
  map.v0 = covered.v0;
  map.u_scale = side / (covered.u1 - covered.u0);
  map.v_scale = side / (covered.v1 - covered.v0);
  return map;
}

}  // namespace

MapProjection parallelMap(const RealBox& volume, Vec3d direction, int side) {
  return makeMap(volume, true, {}, direction, side);
}

MapProjection perspectiveMap(const RealBox& volume, Vec3d eye, Vec3d direction, int side) {
  return makeMap(volume, false, eye, direction, side);
}

MapRect project(const MapProjection& map, const RealBox& box) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  // Nothing may be hidden of a box without a projection.
  if (reachesEye(map, box)) return {-kEndless, -kEndless, kEndless, kEndless};
  const PlaneRect rect =
      // A face's projection moves straight from the near to the far one: both bound the whole box.
      unite(ontoPlane(map, box, box.lo[map.axis]), ontoPlane(map, box, box.hi[map.axis]));
  return {(rect.u0 - map.u0) * map.u_scale, (rect.v0 - map.v0) * map.v_scale,
          (rect.u1 - map.u0) * map.u_scale, (rect.v1 - map.v0) * map.v_scale};
}

std::optional<RealBox> clip(const MapProjection& map, const RealBox& box, const MapRect& visible) {
  if (visible.empty()) return std::nullopt;
  if (reachesEye(map, box)) return box;
  const PlaneRect rect{visible.x0 / map.u_scale + map.u0, visible.y0 / map.v_scale + map.v0,
                       visible.x1 / map.u_scale + map.u0, visible.y1 / map.v_scale + map.v0};
  // Between the faces the rectangle moves from the one to the other, and stays inside their bounds:
  // only these may be cut with the box.
  const PlaneRect bounds =
      unite(fromPlane(map, rect, box.lo[map.axis]), fromPlane(map, rect, box.hi[map.axis]));
  RealBox clipped = box;
  clipped.lo[map.u] = std::max(box.lo[map.u], bounds.u0);
  clipped.lo[map.v] = std::max(box.lo[map.v], bounds.v0);
  clipped.hi[map.u] = std::min(box.hi[map.u], bounds.u1);
  clipped.hi[map.v] = std::min(box.hi[map.v], bounds.v1);
  // The visible part of the map lies beside the box.
  if (!(clipped.lo[map.u] < clipped.hi[map.u] && clipped.lo[map.v] < clipped.hi[map.v]))
    return std::nullopt;
  return clipped;
}

}  // namespace sluice
