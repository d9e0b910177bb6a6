#include "src/render/camera/clipped_box.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sluice {
namespace {

// The point that lies on all three; nullopt if two are parallel, or all to one line.
std::optional<Vec3d> meetingPoint(const ClipPlane& a, const ClipPlane& b, const ClipPlane& c) {
  constexpr double kParallel = 1e-9;  // of unit normals
  const Vec3d along = cross(b.normal, c.normal);
  const double volume = dot(a.normal, along);
  if (std::abs(volume) < kParallel) return std::nullopt;
  return (along * a.offset + cross(c.normal, a.normal) * b.offset +
          cross(a.normal, b.normal) * c.offset) /
         volume;
}

}  // namespace

std::vector<Vec3d> clippedCorners(const Box3& box, std::span<const ClipPlane> planes) {
  std::vector<ClipPlane> faces;
  for (int a = 0; a < 3; ++a) {
    Vec3d normal;
    normal[a] = 1;
    faces.push_back({normal, static_cast<double>(box.hi[a])});
    faces.push_back({normal * -1.0, -static_cast<double>(box.lo[a])});
  }
  for (const ClipPlane& plane : planes) {
    // Normals of one length, so that the tolerance is a distance.
    const double scale = length(plane.normal);
    if (scale > 0) faces.push_back({plane.normal / scale, plane.offset / scale});
  }
  // There are at most 12 faces, so each three of them may be tried.
  const Vec3i size = box.size();
  const double margin = 1e-9 * static_cast<double>(std::max({size.x, size.y, size.z, int64_t{1}}));
  std::vector<Vec3d> corners;
  for (size_t i = 0; i < faces.size(); ++i)
    for (size_t j = i + 1; j < faces.size(); ++j)
      for (size_t k = j + 1; k < faces.size(); ++k) {
        const std::optional<Vec3d> point = meetingPoint(faces[i], faces[j], faces[k]);
        if (point && std::ranges::all_of(faces, [&](const ClipPlane& face) {
              return dot(face.normal, *point) <= face.offset + margin;
            }))
          corners.push_back(*point);
      }
  return corners;
}

}  // namespace sluice
