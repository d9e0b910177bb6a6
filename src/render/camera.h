// Camera: what a user says of the view. View: the same resolved for one volume and picture size.
//
// World space is the volume's (VolumeLayout). Depth is the distance from the eye along `forward`.
// Slices belong to the view (design, point 2): slice k lies at depth
//   first_depth + (k + 1/2) * step,  first_depth = the depth of the volume's eye-side corner,
// the same for every box. Samples at depth <= 0 are behind a perspective eye and are not taken.
#pragma once

#include <optional>

#include "src/base/vec.h"
#include "src/base/volume_source.h"

namespace sluice {

enum class Projection { kOrtho, kPerspective };

// Azimuth 0, elevation 0 looks along -z with +y up; azimuth turns the camera about +y, elevation
// lifts it; zoom 1 fits the sphere around the volume's outer voxel centres.
struct Camera {
  Projection projection = Projection::kOrtho;
  double azimuth_deg = 0, elevation_deg = 0;
  double zoom = 1;
  double field_of_view_deg = 30;  // vertical, perspective only
  // Given together, they replace azimuth, elevation and zoom's distance. World space.
  struct LookAt {
    Vec3d eye, target, up{0, 1, 0};
  };
  std::optional<LookAt> look_at;
};

struct PictureSize {
  int width = 512, height = 512;
};

// The centre of pixel (i, j), j = 0 the top row, is the ray
//   u = 2 (i + 1/2) / width - 1,  v = 1 - 2 (j + 1/2) / height,  a = width / height
//   ortho:       p(depth) = eye + right * (u a half_height) + up * (v half_height) + forward *
//   depth perspective: p(depth) = eye + depth * (forward + right * (u a half_height) + up * (v
//   half_height))
struct View {
  Projection projection = Projection::kOrtho;
  PictureSize size;
  Vec3d eye;                 // world
  Vec3d right, up, forward;  // world, orthonormal
  double half_height = 1;    // ortho: world units; perspective: tan of half the field of view
  double first_depth = 0;    // world units along forward
  double step = 1;           // world units between slices
};

// `step_vox` is in units of the finest spacing. Throws Error when the camera is degenerate (eye on
// target, up along the view, zoom or step not positive, a picture of no pixels).
View resolve(const Camera& camera, const VolumeLayout& layout, PictureSize size, double step_vox);

}  // namespace sluice
