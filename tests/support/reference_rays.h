// The rays of the reference renderer through a volume: through which points of it a pixel's ray
// goes, and at which of them a slice or a voxel plane is sampled. Plain loops in double precision.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/support/reference_renderer.h"
#include "tests/support/reference_values.h"

namespace sluice {

class ReferenceRays {
 public:
  ReferenceRays(const VolumeLayout& layout, const View& view, const ReferenceScene& scene);

  // A point of the ray has the world position start + direction * depth.
  struct Ray {
    Vec3d start, direction;
  };
  // The ray through the middle of pixel (i, j), from the top left.
  Ray through(int i, int j) const;

  struct Sample {
    Vec3d p;       // voxels
    double depth;  // world
    // Whether it counts, and whether rounding decides that: it lies next to a face.
    bool counts, near_face;
  };

  // The voxel coordinates of a world position.
  Vec3d indexOf(Vec3d world) const;
  double finestSpacing() const { return finest_; }
  // The nearest depth and the farthest of what the crop and the clip planes leave, or of the points
  // that show of it; the first in front of a perspective eye.
  std::array<double, 2> shownDepths() const;

  // Calls sample(position, depth) at both ends of the ray's way through what is shown, grown by
  // `grown_vox`, and between them on the voxel planes of one axis.
  template <class F>
  void eachOnPlanes(Vec3d start, Vec3d direction, double grown_vox, F&& sample) const {
    const Vec3d from = indexOf(start);
    const Vec3d d = indexOf(start + direction) - from;
    double enter = nearestDepth(), leave = std::numeric_limits<double>::infinity();
    // A half-space of the shown part: depths with a + b * depth >= 0.
    const auto keep = [&](double a, double b) {
      if (b > 0)
        enter = std::max(enter, -a / b);
      else if (b < 0)
        leave = std::min(leave, -a / b);
      else if (a < 0)
        leave = -std::numeric_limits<double>::infinity();
    };
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      const double edge = kPlaneEdge + grown_vox;
      keep(from[a] - (static_cast<double>(crop_.lo[a]) - edge), d[a]);
      keep(static_cast<double>(crop_.hi[a] - 1) + edge - from[a], -d[a]);
      if (std::abs(d[a]) > (1 + 1e-4) * std::abs(d[axis])) axis = a;
    }
    for (const ReferenceClipPlane& plane : scene_.clip_planes)
      keep(plane.offset + grown_vox * finest_ * length(plane.normal) - dot(plane.normal, start),
           -dot(plane.normal, direction));
    if (enter > leave) return;
    sample(clampedTo(crop_, from + d * enter), enter);
    const auto parts = static_cast<int64_t>(std::ceil(finest_ / view_.step - 1e-6));
    const double a_voxel = static_cast<double>(std::max<int64_t>(1, parts));
    const auto count = static_cast<int64_t>(static_cast<double>(layout_.dims[axis] - 1) * a_voxel);
    for (int64_t i = 0; i <= count; ++i) {
      const double place = static_cast<double>(i) / a_voxel;
      const double depth = (place - from[axis]) / d[axis];
      if (depth < enter || depth > leave) continue;
      Vec3d p = from + d * depth;
      p[axis] = place;
      sample(clampedTo(crop_, p), depth);
    }
    sample(clampedTo(crop_, from + d * leave), leave);
  }

  // Calls sample(Sample) at the slices, each farther by so much of a slice, front to back, until it
  // returns false.
  template <class F>
  void eachSample(Vec3d start, Vec3d direction, double farther, F&& sample) const {
    const double near = scene_.rounding.face_vox;
    for (int64_t k = 0;; ++k) {
      const double place = static_cast<double>(k) + 0.5;
      const double depth = view_.first_depth + (place + farther) * view_.step;
      const double middle = view_.first_depth + place * view_.step;
      if (depth > last_depth_ + (1 + near) * view_.step) return;
      if (middle <= 0 && view_.projection == Projection::kPerspective) continue;
      const Vec3d world = start + direction * depth;
      const Vec3d p = indexOf(world);
      if (!counts(p, world, near)) continue;
      const bool inside = counts(p, world, 0);
      const bool near_face = near > 0 && !counts(p, world, -near);
      if (!sample(Sample{clampedTo(boxOf(layout_.dims), p), depth, inside, near_face})) return;
    }
  }

 private:
  double nearestDepth() const;
  // Whether p lies in the shown part, grown by `grown_vox` on all sides.
  bool counts(Vec3d p, Vec3d world, double grown_vox) const;

  // Faces belong to the volume if voxel planes are sampled, to this part of a voxel.
  static constexpr double kPlaneEdge = 1e-3;

  const VolumeLayout& layout_;
  const View& view_;
  const ReferenceScene& scene_;
  std::array<Vec3d, 3> rows_;  // index = rows * (world - origin)
  const Box3 crop_;
  const double finest_;
  const double last_depth_;
};

}  // namespace sluice
