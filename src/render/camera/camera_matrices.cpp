#include "src/render/camera/camera_matrices.h"

#include <algorithm>

namespace sluice {
namespace {

// dot(world - eye, along) in column `column`.
void setColumn(Matrix4& m, size_t column, const View& view, Vec3d along, double offset = 0) {
  m[column] = static_cast<float>(along.x);
  m[4 + column] = static_cast<float>(along.y);
  m[8 + column] = static_cast<float>(along.z);
  m[12 + column] = static_cast<float>(offset - dot(view.eye, along));
}

}  // namespace

Matrix4 cameraFromWorld(const View& view) {
  Matrix4 m{};
  setColumn(m, 0, view, view.right);
  setColumn(m, 1, view, view.up);
  setColumn(m, 2, view, view.forward);
  m[15] = 1;
  return m;
}

Matrix4 ndcFromWorld(const View& view) {
  const Vec3d across = view.right * (0.5 / (view.half_height * view.size.aspect()));
  const Vec3d down = view.up * (-0.5 / view.half_height);
  Matrix4 m{};
  if (view.projection == Projection::kPerspective) {
    setColumn(m, 0, view, across + view.forward * 0.5);
    setColumn(m, 1, view, down + view.forward * 0.5);
    setColumn(m, 2, view, view.forward, -std::max(view.first_depth, view.step));
    setColumn(m, 3, view, view.forward);
  } else {
    setColumn(m, 0, view, across, 0.5);
    setColumn(m, 1, view, down, 0.5);
    setColumn(m, 2, view, view.forward);
    m[15] = 1;
  }
  return m;
}

float screenWindowWidth(const View& view) {
  if (view.projection == Projection::kOrtho) return 1;
  return static_cast<float>(2 * view.half_height * view.size.aspect());
}

}  // namespace sluice
