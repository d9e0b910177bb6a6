#include "src/gl/box_buffer.h"

#include <algorithm>
#include <cmath>

#include "src/base/values/corners.h"

namespace sluice {
namespace {

// The rasteriser only proposes pixels; the shader decides which slices of a pixel's ray are in the
// box. So the drawn cube is a little larger, in voxels and in pixels, than the box.
constexpr double kMarginVoxels = 0.01;
constexpr double kMarginPixels = 0.1;

Vec3d absolute(Vec3d v) {
  return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}

struct ClipCorner {
  double x, y, w;
};

ClipCorner project(const FrameSetup& setup, Vec3d index) {
  const auto row = [&](const std::array<double, 4>& r) {
    return r[0] * index.x + r[1] * index.y + r[2] * index.z + r[3];
  };
  return {row(setup.clip_from_index[0]), row(setup.clip_from_index[1]),
          row(setup.clip_from_index[2])};
}

// Nearest and farthest slice numbers of the box's corners.
std::array<double, 2> sliceSpan(const FrameSetup& setup, Vec3d lo, Vec3d hi) {
  const RayGrid& rays = setup.rays;
  std::array<double, 2> span{1e300, -1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = cornerOf(lo, hi, corner);
    double k = 0;
    if (setup.projection == Projection::kPerspective) {
      // The depth is w in perspective, and slices lie at equal depths.
      k = (project(setup, p).w - setup.first_depth) / setup.depth_step;
    } else {
      // The slice planes are spanned by origin_dx and origin_dy.
      const Vec3d normal = cross(rays.origin_dx, rays.origin_dy);
      k = dot(p - rays.origin0, normal) / dot(rays.step0, normal);
    }
    span = {std::min(span[0], k), std::max(span[1], k)};
  }
  return span;
}

class TexelWriter {
 public:
  explicit TexelWriter(size_t boxes) { texels.reserve(boxes * kTexelsPerBox * 4); }
  void add(double x, double y, double z, double w) {
    for (const double v : {x, y, z, w}) texels.push_back(static_cast<float>(v));
  }
  void add(Vec3d v, double w = 0) { add(v.x, v.y, v.z, w); }
  std::vector<float> texels;
};

void addBox(const FrameSetup& setup, const BoxDraw& box, TexelWriter& out) {
  const RayGrid& rays = setup.rays;
  const Vec3d lo = toDouble(box.cells.lo), hi = toDouble(box.cells.hi);
  const auto [near_k, far_k] = sliceSpan(setup, lo, hi);
  // A pixel's size in index space at the farthest slice, where it is largest.
  const Vec3d pixel = absolute(rays.origin_dx) + absolute(rays.origin_dy) +
                      (absolute(rays.step_dx) + absolute(rays.step_dy)) * std::max(0.0, far_k);
  const Vec3d margin = pixel * kMarginPixels + Vec3d{kMarginVoxels, kMarginVoxels, kMarginVoxels};
  const OuterFaces outer = outerFaces(setup, box.cells);
  int faces = 0;
  for (size_t a = 0; a < 3; ++a) faces |= (outer.lo[a] ? 1 : 0) << a | (outer.hi[a] ? 8 : 0) << a;
  for (int corner = 0; corner < 8; ++corner) {
    const ClipCorner clip = project(setup, cornerOf(lo - margin, hi + margin, corner));
    out.add(clip.x, clip.y, clip.w, faces);
  }
  // Slice numbers stay exact in single precision up to 2^24.
  // Places are counted from the box's first slice, since far numbers of slices would lose digits in
  // single precision.
  const double first_k = std::max(static_cast<double>(setup.first_slice), std::floor(near_k));
  const int turn = box.texels.axes[2];
  out.add(lo - rays.origin0, first_k);
  out.add(hi - rays.origin0, turn);
  const double k = first_k + 0.5;
  const Vec3d texel_centre{0.5, 0.5, 0.5};
  const auto along = [&](Vec3d way) { return box.texels(way) - box.texels.offset; };
  const Vec3d corner = box.texels(lo) + texel_centre;
  out.add(box.texels(rays.origin0 + rays.step0 * k) + texel_centre, corner.x);
  out.add(along(rays.origin_dx + rays.step_dx * k), corner.y);
  out.add(along(rays.origin_dy + rays.step_dy * k), corner.z);
}

}  // namespace

std::vector<float> boxTexels(const FrameSetup& setup, std::span<const BoxDraw> boxes) {
  TexelWriter out(boxes.size());
  for (const BoxDraw& box : boxes) addBox(setup, box, out);
  return std::move(out.texels);
}

bool isMirrored(const FrameSetup& setup) {
  const RayGrid& rays = setup.rays;
  const bool perspective = setup.projection == Projection::kPerspective;
  const Vec3d right = perspective ? rays.step_dx : rays.origin_dx;
  const Vec3d up = perspective ? rays.step_dy : rays.origin_dy;
  // right x up points toward the viewer in a right-handed space.
  return dot(cross(right, up), rays.step0) > 0;
}

}  // namespace sluice
