#include "tests/support/reference_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace sluice {
namespace {

// The value that stands for infinities and anything as far away (src/volume/voxels/device_voxel.h).
constexpr double kFarthest = 1e30;

// If two labels' weights are this close, the greater label counts.
constexpr double kLabelTie = 1e-3;

template <class T>
double trilinear(const std::byte* bytes, Vec3i dims, Vec3d p) {
  const auto* voxels = reinterpret_cast<const T*>(bytes);
  Vec3i i;
  Vec3d f;
  for (int a = 0; a < 3; ++a) {
    i[a] = std::min(static_cast<int64_t>(p[a]), dims[a] - 2);
    f[a] = p[a] - static_cast<double>(i[a]);
  }
  // Infinities are far values like others; std::clamp lets NaN through.
  const auto voxel = [&](int64_t x, int64_t y, int64_t z) {
    const T v = voxels[((i.z + z) * dims.y + i.y + y) * dims.x + i.x + x];
    return std::clamp(static_cast<double>(v), -kFarthest, kFarthest);
  };
  // A voxel of no weight does not count, even if it is NaN.
  const auto between = [](double t, auto&& first, auto&& second) {
    return t == 0 ? first() : first() * (1 - t) + second() * t;
  };
  const auto along_x = [&](int64_t y, int64_t z) {
    return between(
        f.x, [&] { return voxel(0, y, z); }, [&] { return voxel(1, y, z); });
  };
  const auto along_y = [&](int64_t z) {
    return between(
        f.y, [&] { return along_x(0, z); }, [&] { return along_x(1, z); });
  };
  return between(
      f.z, [&] { return along_y(0); }, [&] { return along_y(1); });
}

template <class T>
ReferenceValues::Label heaviest(const std::byte* bytes, Vec3i dims, Vec3d p) {
  const auto* voxels = reinterpret_cast<const T*>(bytes);
  std::map<double, double> weights;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3i i;
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const int64_t low = std::min(static_cast<int64_t>(p[a]), dims[a] - 2);
      const double t = p[a] - static_cast<double>(low);
      const bool upper = (corner >> a & 1) != 0;
      i[a] = low + (upper ? 1 : 0);
      weight *= upper ? t : 1 - t;
    }
    const auto value = static_cast<double>(voxels[(i.z * dims.y + i.y) * dims.x + i.x]);
    weights[std::isnan(value) ? -std::numeric_limits<double>::max() : value] += weight;
  }
  // Ascending, so that of two with the same weight the greater one stays.
  ReferenceValues::Label best{0, 0};
  double most = -1, second = -1;
  for (const auto& [value, weight] : weights) {
    if (weight > most - kLabelTie) {
      second = std::max(second, most);
      most = weight;
      best.value = value;
    } else {
      second = std::max(second, weight);
    }
  }
  if (best.value == -std::numeric_limits<double>::max())
    best.value = std::numeric_limits<double>::quiet_NaN();
  best.lead = std::abs(std::abs(most - second) - kLabelTie);
  return best;
}

}  // namespace

Vec3d clampedTo(const Box3& box, Vec3d p) {
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(p[a], static_cast<double>(box.lo[a]), static_cast<double>(box.hi[a] - 1));
  return p;
}

ReferenceValues::ReferenceValues(VolumeSource& source, int64_t time) : layout_(source.layout()) {
  bytes_.resize(static_cast<size_t>(volume(layout_.dims)) * bytesPerVoxel(layout_.type));
  source.readRegion(time, boxOf(layout_.dims), bytes_);
  trilinear_ = visitVoxelType(layout_.type, [](auto tag) { return &trilinear<decltype(tag)>; });
  label_ = visitVoxelType(layout_.type, [](auto tag) { return &heaviest<decltype(tag)>; });
}

ReferenceValues::Label ReferenceValues::labelAt(Vec3d p) const {
  Label label = label_(bytes_.data(), layout_.dims, p);
  label.value = label.value * layout_.value_scale + layout_.value_offset;
  return label;
}

double ReferenceValues::at(Vec3d p) const {
  return trilinear_(bytes_.data(), layout_.dims, p) * layout_.value_scale + layout_.value_offset;
}

}  // namespace sluice
