// Camera: the user's options of the view. View: the same resolved for one volume and picture size.
//
// World space is the volume's (VolumeLayout). Depth is the distance from the eye along `forward`.
// Slices belong to the view (design, point 2): slice k lies at depth
//   first_depth + (k + 1/2) * step,  first_depth = the depth of the volume's eye-side corner,
// the same for every box. Samples at depth <= 0 are behind a perspective eye and are not taken.
#pragma once

#include <optional>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"
#include "src/device/view_values.h"
#include "src/render/camera/camera_views.h"

namespace sluice {

// The framing at zoom 1, see camera_framing.h.
struct Framing {
  Vec3d target;  // world
  // Ortho: half the picture's height in world units. Perspective: from the eye to the target.
  double reach = 1;
  // The target's place in the picture, right of and above its middle, in halves of its width and
  // height; the same at any zoom.
  double right = 0, up = 0;
};

// Starts from a named view; azimuth turns the camera about the up axis, to the viewer's right, and
// elevation lifts it.
struct Camera {
  Projection projection = Projection::kOrtho;
  ViewName view = ViewName::kPlain;
  std::optional<Vec3d> up;  // world: the up direction of the picture; unset: the view's
  double azimuth_deg = 0, elevation_deg = 0;
  double zoom = 1;
  double field_of_view_deg = 30;  // vertical, perspective only
  // Unset: zoom 1 fits the sphere around the volume's outer voxel centres.
  std::optional<Framing> framing;
  // Replaces view, azimuth, elevation and framing. World space.
  struct LookAt {
    Vec3d eye, target;
  };
  std::optional<LookAt> look_at;
};

// The centre of pixel (i, j), j = 0 the top row, is the ray
//   u = 2 (i + 1/2) / width - 1,  v = 1 - 2 (j + 1/2) / height,  a = width / height
//   ortho:       p(depth) = eye + right * (u a half_height) + up * (v half_height)
//                           + forward * depth
//   perspective: p(depth) = eye + depth * (forward + right * (u a half_height)
//                                          + up * (v half_height))
struct View {
  Projection projection = Projection::kOrtho;
  PictureSize size;
  Vec3d eye;                 // world
  Vec3d right, up, forward;  // world, orthonormal
  double half_height = 1;    // ortho: world units; perspective: tan of half the field of view
  double first_depth = 0;    // world units along forward
  double step = 1;           // world units between slices

  friend bool operator==(const View&, const View&) = default;
};

// Throws Error: a zoom, an angle or an up direction that is none, a picture of no pixels.
void requireValid(const Camera& camera, PictureSize size);
// The same, and a view of the volume that is none: an eye on its target, an up direction along it.
void requireValid(const Camera& camera, const VolumeLayout& layout, PictureSize size);

// `step_vox` is in units of the finest spacing. Throws Error when the camera is not valid or the
// step not positive.
View resolve(const Camera& camera, const VolumeLayout& layout, PictureSize size, double step_vox);

// The directions of the picture's sides. Requires: valid, no look_at.
ViewAxes axesOf(const Camera& camera, WorldFrame frame);

}  // namespace sluice
