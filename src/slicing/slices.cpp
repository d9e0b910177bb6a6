#include "src/slicing/slices.h"

#include <cmath>

#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

// Rounded sines leave small components along the other axes in a view along an axis. Components up
// to this count as none: they move a slice by less than the tolerance of a vertex over any block.
constexpr double kStraight = 1e-9;

}  // namespace

SlicePlanes slicePlanes(const View& view, const VolumeLayout& layout, Vec3d origin) {
  SlicePlanes planes;
  for (int a = 0; a < 3; ++a)
    planes.normal[a] = dot(layout.axes[static_cast<size_t>(a)], view.forward) * layout.spacing[a];
  const double size = length(planes.normal);
  for (int a = 0; a < 3; ++a)
    if (std::abs(planes.normal[a]) < kStraight * size) planes.normal[a] = 0;
  const double at_origin = dot(worldFromIndex(layout, origin) - view.eye, view.forward);
  planes.first = view.first_depth - at_origin;
  planes.step = view.step;
  // A perspective view has no slice at or behind the eye: its rays only begin there.
  if (view.projection == Projection::kPerspective && view.first_depth <= 0)
    planes.first_slice = static_cast<int64_t>(std::floor(-view.first_depth / view.step - 0.5)) + 1;
  return planes;
}

}  // namespace sluice
