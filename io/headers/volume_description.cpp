#include "io/headers/volume_description.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr double kLeastStep = 1e-30, kMostStep = 1e30;
// Voxels are within 1e30 (device_voxel.h), so that scaled values and squares of their differences
// stay finite.
constexpr double kMostValue = 1e100;
constexpr double kLeastDeterminant = 1e-6;
constexpr int64_t kMostBytes = int64_t{1} << 62;

Vec3d perpendicularTo(const std::vector<Vec3d>& unit) {
  if (unit.size() == 2) return normalized(cross(unit[0], unit[1]));
  // The coordinate axis that is farthest from the one given, without its share along it.
  int axis = 1;
  for (const int candidate : {2, 0})
    if (std::abs(unit[0][candidate]) < std::abs(unit[0][axis])) axis = candidate;
  Vec3d other;
  other[axis] = 1;
  return normalized(other - dot(other, unit[0]) * unit[0]);
}

double determinant(const std::array<Vec3d, 3>& axes) {
  return dot(cross(axes[0], axes[1]), axes[2]);
}

}  // namespace

int64_t checkedVolumeBytes(const std::string& path, const VolumeLayout& layout) {
  int64_t bytes = static_cast<int64_t>(bytesPerVoxel(layout.type));
  const Vec3i d = layout.dims;
  for (const int64_t factor : {d.x, d.y, d.z, layout.time_steps}) {
    if (factor < 1)
      fail("{}: dimensions {} x {} x {} x {} steps: each must be 1 or more", path, d.x, d.y, d.z,
           layout.time_steps);
    if (__builtin_mul_overflow(bytes, factor, &bytes) || bytes > kMostBytes)
      fail("{}: {} x {} x {} x {} steps x {} bytes ({}) do not fit 2^62 bytes", path, d.x, d.y, d.z,
           layout.time_steps, bytesPerVoxel(layout.type), name(layout.type));
  }
  return bytes;
}

std::string sizeArithmetic(const VolumeLayout& layout, int64_t skipped, int64_t files) {
  const int64_t voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout.type));
  const int64_t bytes = volume(layout.dims) * layout.time_steps * voxel_bytes / files + skipped;
  const std::string steps =
      layout.time_steps > 1 ? fmt::format(" x {} steps", layout.time_steps) : "";
  const std::string share = files > 1 ? fmt::format(" / {} files", files) : "";
  return fmt::format("{} x {} x {}{} x {} byte{} ({}){} + {} skipped = {} bytes", layout.dims.x,
                     layout.dims.y, layout.dims.z, steps, voxel_bytes, voxel_bytes == 1 ? "" : "s",
                     name(layout.type), share, skipped, bytes);
}

void setSteps(const std::string& path, std::vector<Vec3d> steps, VolumeLayout& layout) {
  SLUICE_CHECK(!steps.empty() && steps.size() <= 3);
  std::vector<Vec3d> unit;
  for (size_t axis = 0; axis < steps.size(); ++axis) {
    const Vec3d step = steps[axis];
    const bool finite = std::isfinite(step.x) && std::isfinite(step.y) && std::isfinite(step.z);
    const double size = finite ? std::hypot(step.x, step.y, step.z) : 0;
    if (!(size >= kLeastStep && size <= kMostStep))
      fail("{}: the spacing of axis {}, the step ({}, {}, {}), is not from {} to {}", path, axis,
           step.x, step.y, step.z, kLeastStep, kMostStep);
    layout.spacing[static_cast<int>(axis)] = size;
    unit.push_back(step / size);
  }
  while (unit.size() < 3) {
    layout.spacing[static_cast<int>(unit.size())] = 1;
    unit.push_back(perpendicularTo(unit));
  }
  layout.axes = {unit[0], unit[1], unit[2]};
  if (!(std::abs(determinant(layout.axes)) >= kLeastDeterminant))
    fail("{}: the directions of its axes lie in one plane", path);
}

std::string negativeSpacingNote(const std::string& path, std::span<const double> spacing) {
  if (std::ranges::none_of(spacing, [](double size) { return size < 0; })) return "";
  return fmt::format(
      "{}: its spacing is {}: an axis of negative spacing runs the other way, so that the volume "
      "is a mirror image",
      path, fmt::join(spacing, " x "));
}

void setOrigin(const std::string& path, Vec3d origin, VolumeLayout& layout) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(origin[axis]) <= kMostStep))
      fail("{}: origin ({}, {}, {}) is not finite or beyond {}", path, origin.x, origin.y, origin.z,
           kMostStep);
  layout.origin = origin;
}

void setStoredRange(const std::string& path, double lo, double hi, VolumeLayout& layout) {
  if (!(std::abs(lo) <= kMostValue) || !(std::abs(hi) <= kMostValue)) return;
  if (lo > hi) fail("{}: its least value {} is above its greatest, {}", path, lo, hi);
  layout.stored_range = ValueRange{lo, hi};
}

void setValueScale(const std::string& path, double scale, double offset, VolumeLayout& layout) {
  const double size = std::abs(scale);
  if (!(size >= 1 / kMostValue && size <= kMostValue) || !(std::abs(offset) <= kMostValue))
    fail(
        "{}: values are stored * {:g} + {:g}: expected a factor of {:g} to {:g} and an offset "
        "within "
        "{:g}",
        path, scale, offset, 1 / kMostValue, kMostValue, kMostValue);
  layout.value_scale = scale;
  layout.value_offset = offset;
}

}  // namespace sluice
