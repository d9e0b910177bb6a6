#include "src/render/camera/pixel_sizes.h"

#include <algorithm>
#include <limits>

#include "src/base/values/corners.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

constexpr int kCorners = 8;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

}  // namespace

double PixelSizes::of(const LevelLayout& level, const Box3& cells) const {
  const std::optional<double> pixel = smallestPixel(cells);
  if (!pixel) return 0;
  double widest = 0;
  for (int a = 0; a < 3; ++a)
    widest = std::max(widest, volume_.spacing[a] * level.placement.scale[a]);
  // At the eye a pixel has no width: any voxel is too coarse.
  return *pixel > 0 ? widest / *pixel : kUnbounded;
}

double PixelSizes::depthOf(const Box3& cells) const {
  const Vec3d middle = (toDouble(cells.lo) + toDouble(cells.hi)) * 0.5;
  return dot(worldFromIndex(volume_, middle) - view_.eye, view_.forward);
}

std::optional<double> PixelSizes::smallestPixel(const Box3& cells) const {
  const bool is_perspective = view_.projection == Projection::kPerspective;
  double nearest = kUnbounded, farthest = -nearest;
  // Whether all corners lie beyond the right, left, upper and lower side of the picture.
  bool right = true, left = true, above = true, below = true;
  for (int corner = 0; corner < kCorners; ++corner) {
    const Vec3d at = toDouble(cornerOf(cells, corner));
    const Vec3d from_eye = worldFromIndex(volume_, at) - view_.eye;
    const double depth = dot(from_eye, view_.forward);
    // The sides are planes through the eye, so that the test holds for corners behind it, too.
    const double half = view_.half_height * (is_perspective ? depth : 1);
    const double x = dot(from_eye, view_.right), y = dot(from_eye, view_.up);
    right = right && x > aspect_ * half;
    left = left && x < -aspect_ * half;
    above = above && y > half;
    below = below && y < -half;
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  if (right || left || above || below) return std::nullopt;
  const double pixel = 2 * view_.half_height / view_.size.height;
  if (!is_perspective) return pixel;
  // All of the box lies behind the eye.
  if (farthest <= 0) return std::nullopt;
  return pixel * std::max(0.0, nearest);
}

}  // namespace sluice
