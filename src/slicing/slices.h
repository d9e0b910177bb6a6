// Slices: the view-aligned planes on which a volume is sampled, and the polygons that cutting boxes
// with them gives. Shared by the incremental slicer and the plain one. Plain data, any thread.
//
// This folder is Li's slicing (2003, section 3.3) as in the paper, its plain oracle and the costs
// of both, held by tests and measured by `sluice bench slicing`. No frame uses it: a device draws a
// box once and takes the same slices along each pixel's ray.
//
// Slices belong to the view, not to a box (design, point 2): slice k lies at depth (k + 1/2) steps
// from the volume's eye-side corner for every box. A box is half-open along the view: a slice that
// touches its nearest corner only just cuts it, one at its farthest corner does not. Corners count
// as passed by the same comparison of the same numbers in each box, so that boxes which share a
// face agree which of them a slice cuts there.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"
#include "src/render/camera/camera.h"

namespace sluice {

// Planes dot(normal, p) = first + (k + 1/2) * step of positions p relative to some origin, in
// voxels. Requires: normal not zero, step > 0.
struct SlicePlanes {
  Vec3d normal;
  double first = 0, step = 1;
  int64_t first_slice = 0;  // nearer ones lie behind the eye

  double depthOf(Vec3d p) const { return normal.x * p.x + normal.y * p.y + normal.z * p.z; }
  double depthOfSlice(int64_t k) const { return first + (static_cast<double>(k) + 0.5) * step; }
};

// The slices of a view, for positions relative to index position `origin`. An origin near the boxes
// to be cut keeps vertices exact in single precision, however large the volume.
SlicePlanes slicePlanes(const View& view, const VolumeLayout& layout, Vec3d origin = {0, 0, 0});

// A box to be cut; texture coordinates are position * texture_scale + texture_offset.
// Requires: lo < hi on each axis.
struct SlicedBox {
  Vec3d lo, hi;
  Vec3d texture_scale{1, 1, 1}, texture_offset;
};

struct SliceVertex {
  std::array<float, 3> position, texture;
};
// A convex polygon, counter-clockwise seen from the eye if index space is right-handed.
struct SlicePolygon {
  int64_t slice = 0;
  uint32_t first = 0, count = 0;  // into SliceList::vertices; 3 to 6 vertices, which may coincide
};
struct SliceList {
  std::vector<SliceVertex> vertices;
  std::vector<SlicePolygon> polygons;  // box after box, front to back in each
};

}  // namespace sluice
