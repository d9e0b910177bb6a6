// VertexMaker: the vertices of a surface on the edges between voxels.
//
// A vertex lies where the value on its edge, interpolated linearly, is the threshold, and at least
// kLeastShare of the edge from both ends: vertices of several edges never coincide, so that no
// triangle collapses and the mesh stays watertight in formats that join vertices by their position.
// Its normal is the gradient by central differences at both ends of the edge (one-sided ones at the
// volume's border), interpolated likewise, and points to lower values. Pure functions of the
// voxels, any thread.
#pragma once

#include <algorithm>
#include <array>

#include "io/meshes/mesh_file.h"
#include "src/surface/inside_set.h"
#include "src/surface/piece_voxels.h"
#include "src/surface/surface_place.h"

namespace sluice {

inline constexpr double kLeastShare = 1.0 / 1024;

// Makes vertices from device voxels of type T.
template <class T>
class VertexMaker {
 public:
  // `to_lower`: -1 if values rise with the device values, otherwise 1.
  VertexMaker(const SurfacePlace& place, const InsideSet& inside, double to_lower)
      : place_(place), inside_(inside), to_lower_(to_lower) {}

  // On the edge from a voxel of the run to the next one along the axis. Requires: one of them is
  // inside, both are in the run's voxels.
  MeshVertex onEdge(const VoxelRun& run, Vec3i voxel, int axis) const {
    const Vec3i size = run.voxels.size(), local = voxel - run.voxels.lo;
    const std::array<int64_t, 3> stride{1, size.x, size.x * size.y};
    const T* const at =
        reinterpret_cast<const T*>(run.bytes) + local.x + local.y * stride[1] + local.z * stride[2];
    const int64_t ahead = stride[static_cast<size_t>(axis)];
    const double here = at[0], next = at[ahead];
    const double share =
        std::clamp((inside_.level - here) / (next - here), kLeastShare, 1 - kLeastShare);
    Vec3d derivatives;
    for (int a = 0; a < 3; ++a) {
      const int64_t by = stride[static_cast<size_t>(a)];
      const double d = derivative(at, by, local[a], size[a]);
      const double d_next = derivative(at + ahead, by, local[a] + (a == axis ? 1 : 0), size[a]);
      derivatives[a] = d + (d_next - d) * share;
    }
    Vec3d normal = place_.gradient(derivatives) * to_lower_;
    if (!(dot(normal, normal) > 0))
      normal = place_.slope[static_cast<size_t>(axis)] * (inside_.contains(here) ? 1.0 : -1.0);
    Vec3d position = toDouble(voxel);
    position[axis] += share;
    return {floatsOf(place_.worldFromVoxel(position)), unitFloats(normal)};
  }

 private:
  static double derivative(const T* at, int64_t by, int64_t place, int64_t size) {
    const bool has_before = place > 0, has_behind = place + 1 < size;
    const double before = has_before ? at[-by] : at[0], behind = has_behind ? at[by] : at[0];
    return (behind - before) * (has_before && has_behind ? 0.5 : 1.0);
  }

  const SurfacePlace& place_;
  const InsideSet& inside_;
  const double to_lower_;
};

// On the border of a closed surface, next to a voxel inside: on the edge that leads out of the
// volume, forwards or backwards along the axis.
inline MeshVertex borderVertex(const SurfacePlace& place, Vec3i voxel, int axis, bool is_forwards) {
  const double sign = is_forwards ? 1 : -1;
  Vec3d position = toDouble(voxel);
  position[axis] += sign * kLeastShare;
  return {floatsOf(place.worldFromVoxel(position)),
          unitFloats(place.slope[static_cast<size_t>(axis)] * sign)};
}

}  // namespace sluice
