// Vec3 and Box3: positions, sizes and half-open boxes of voxels, cells, pages and blocks.
//
// Index arithmetic is 64-bit everywhere (design: sizes are 64-bit); x is the fastest axis. Plain
// values, no ownership, safe from any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace sluice {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr const T& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;

  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  // Component by component.
  friend constexpr Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend constexpr Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
  friend constexpr Vec3 operator*(Vec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(T s, Vec3 a) { return a * s; }
  friend constexpr Vec3 operator/(Vec3 a, T s) { return {a.x / s, a.y / s, a.z / s}; }
};

using Vec3i = Vec3<int64_t>;
using Vec3d = Vec3<double>;

template <class T>
constexpr Vec3<T> min(Vec3<T> a, Vec3<T> b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
template <class T>
constexpr Vec3<T> max(Vec3<T> a, Vec3<T> b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
constexpr Vec3d toDouble(Vec3i v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
constexpr double dot(Vec3d a, Vec3d b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3d a) {
  return std::sqrt(dot(a, a));
}
// Requires: length(a) > 0.
inline Vec3d normalized(Vec3d a) {
  return a / length(a);
}
// The product of the components: voxels of a size, blocks of a grid.
constexpr int64_t volume(Vec3i size) {
  return size.x * size.y * size.z;
}
// The quotient, rounded up. Requires: a >= 0, b > 0.
constexpr int64_t ceilDiv(int64_t a, int64_t b) {
  return (a + b - 1) / b;
}

// The half-open box lo <= p < hi, of voxels or of cells according to the variable's name.
struct Box3 {
  Vec3i lo, hi;

  friend constexpr bool operator==(const Box3&, const Box3&) = default;
  constexpr bool empty() const { return hi.x <= lo.x || hi.y <= lo.y || hi.z <= lo.z; }
  constexpr Vec3i size() const { return hi - lo; }
  // Number of elements; 0 when empty.
  constexpr int64_t count() const { return empty() ? 0 : volume(size()); }
  constexpr bool contains(Vec3i p) const {
    return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x < hi.x && p.y < hi.y && p.z < hi.z;
  }
  constexpr bool contains(const Box3& b) const {
    return b.empty() || (contains(b.lo) && b.hi.x <= hi.x && b.hi.y <= hi.y && b.hi.z <= hi.z);
  }
};

constexpr Box3 boxOf(Vec3i size) {
  return {{0, 0, 0}, size};
}
// May be empty.
constexpr Box3 intersect(const Box3& a, const Box3& b) {
  return {max(a.lo, b.lo), min(a.hi, b.hi)};
}
constexpr Box3 translate(const Box3& b, Vec3i by) {
  return {b.lo + by, b.hi + by};
}
// The smallest box that holds both; an empty one adds nothing.
constexpr Box3 unite(const Box3& a, const Box3& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {min(a.lo, b.lo), max(a.hi, b.hi)};
}

}  // namespace sluice
