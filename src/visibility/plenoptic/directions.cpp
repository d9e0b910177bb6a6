#include "src/visibility/plenoptic/directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sluice {
namespace {

constexpr double kPi = std::numbers::pi;

struct Angles {
  double theta, phi;  // 0..pi/2, 0..2 pi
};

Angles anglesOf(Vec3d direction) {
  // A ray and its opposite pass through the same voxels.
  if (direction.z < 0) direction = direction * -1.0;
  const double theta = std::atan2(std::hypot(direction.x, direction.y), direction.z);
  double phi = std::atan2(direction.y, direction.x);
  if (phi < 0) phi += 2 * kPi;
  return {theta, phi};
}

Vec3d directionOf(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

int mainAxis(Vec3d d) {
  d = {std::abs(d.x), std::abs(d.y), std::abs(d.z)};
  if (d.z >= d.x && d.z >= d.y) return 2;
  return d.y >= d.x ? 1 : 0;
}

std::vector<int> allCells(int count) {
  std::vector<int> cells(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) cells[static_cast<size_t>(i)] = i;
  return cells;
}

}  // namespace

int DirectionGrid::cellOf(Vec3d direction) const {
  const Angles at = anglesOf(direction);
  const double side = kPi / 2 / rows;
  const int row = std::clamp(static_cast<int>(at.theta / side), 0, rows - 1);
  const int column = std::clamp(static_cast<int>(at.phi / side), 0, columns() - 1);
  return row * columns() + column;
}

DirectionSlopes DirectionGrid::slopesOf(int cell) const {
  const double side = kPi / 2 / rows;
  const int row = cell / columns(), column = cell % columns();
  DirectionSlopes slopes;
  slopes.axis = mainAxis(directionOf((row + 0.5) * side, (column + 0.5) * side));
  const int u = (slopes.axis + 1) % 3, v = (slopes.axis + 2) % 3;
  slopes.u_lo = slopes.v_lo = 1e9;
  slopes.u_hi = slopes.v_hi = -1e9;
  // Columns end at quarters of phi, so that each slope is monotonous in both angles and has its
  // extremes at the corners.
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3d d = directionOf((row + (corner & 1)) * side, (column + (corner >> 1)) * side);
    slopes.u_lo = std::min(slopes.u_lo, d[u] / d[slopes.axis]);
    slopes.u_hi = std::max(slopes.u_hi, d[u] / d[slopes.axis]);
    slopes.v_lo = std::min(slopes.v_lo, d[v] / d[slopes.axis]);
    slopes.v_hi = std::max(slopes.v_hi, d[v] / d[slopes.axis]);
  }
  // Snaps rounding errors to 0, so that the slopes of an axis are exactly 0.
  for (double* lo : {&slopes.u_lo, &slopes.v_lo}) *lo = std::abs(*lo) < 1e-12 ? 0 : *lo;
  for (double* hi : {&slopes.u_hi, &slopes.v_hi}) *hi = std::abs(*hi) < 1e-12 ? 0 : *hi;
  return slopes;
}

std::vector<int> DirectionGrid::cellsToward(Vec3d eye, Vec3d lo, Vec3d hi) const {
  // The cone around the box's middle that holds its corners holds the box.
  const Vec3d middle = (lo + hi) * 0.5 - eye;
  const double radius = length(hi - lo) * 0.5;
  // An eye in the box or near it may see it in any direction. The hundredth covers rounding.
  if (length(middle) <= 1.01 * radius) return allCells(count());
  const double reach = std::asin(radius / length(middle)) + 1e-9;
  const Angles at = anglesOf(middle);
  const double side = kPi / 2 / rows;
  std::vector<int> cells;
  const auto add = [&](double theta, double phi) {
    const int first = std::max(0, static_cast<int>(std::floor((theta - reach) / side)));
    const int last = std::min(rows - 1, static_cast<int>(std::floor((theta + reach) / side)));
    // A cone around the pole has all phi.
    const double around = theta - reach <= 0 || theta + reach >= kPi
                              ? kPi
                              : std::asin(std::min(1.0, std::sin(reach) / std::sin(theta)));
    for (int row = first; row <= last; ++row)
      for (int i = static_cast<int>(std::floor((phi - around) / side));
           i <= static_cast<int>(std::floor((phi + around) / side)); ++i)
        // Columns go round.
        cells.push_back(row * columns() + ((i % columns()) + columns()) % columns());
  };
  add(at.theta, at.phi);
  // Directions below the horizon are seen from the other side.
  if (at.theta + reach > kPi / 2) add(kPi - at.theta, at.phi + kPi);
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace sluice
