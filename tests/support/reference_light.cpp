#include "tests/support/reference_light.h"

#include <algorithm>
#include <cmath>

namespace sluice {
namespace {

constexpr double kMostExtinction = 16 * 0.693147180559945309;  // 2^-16 passes

double extinction(double opacity) {
  return opacity < 1 ? std::min(-std::log(1 - opacity), kMostExtinction) : kMostExtinction;
}

// The weights by which texels around a position count, x fastest.
template <class Visit>
void eachAround(Vec3d at, const Visit& visit) {
  Vec3i low;
  for (int a = 0; a < 3; ++a) low[a] = static_cast<int64_t>(std::floor(at[a] + 1e-12));
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Vec3i here;
    for (int a = 0; a < 3; ++a) {
      const int64_t up = corner >> a & 1;
      here[a] = low[a] + up;
      weight *= 1 - std::abs(at[a] - static_cast<double>(here[a]));
    }
    if (weight > 0) visit(here, weight);
  }
}

// The coordinates of a world vector along the volume's edges from voxel to voxel.
Vec3d alongVoxels(const VolumeLayout& layout, Vec3d world) {
  const std::array<Vec3d, 3> e = {layout.axes[0] * layout.spacing.x,
                                  layout.axes[1] * layout.spacing.y,
                                  layout.axes[2] * layout.spacing.z};
  const double determinant = dot(e[0], cross(e[1], e[2]));
  return {dot(world, cross(e[1], e[2])) / determinant, dot(world, cross(e[2], e[0])) / determinant,
          dot(world, cross(e[0], e[1])) / determinant};
}

}  // namespace

ReferenceLight::ReferenceLight(const VolumeLayout& layout, const View& view,
                               const ReferenceScene& scene, const ReferenceValues& values)
    : layout_(layout) {
  if (!scene.lighting || !(scene.lighting->shadows > 0 || scene.lighting->occlusion > 0)) return;
  finest_ = std::min({layout.spacing.x, layout.spacing.y, layout.spacing.z});
  for (int a = 0; a < 3; ++a)
    longest_ = std::max(longest_, layout.spacing[a] * static_cast<double>(layout.dims[a]));
  // At most 128 texels along the longest side, and as wide along the others.
  for (int a = 0; a < 3; ++a) {
    while (static_cast<double>(voxels_[a]) * layout.spacing[a] * 128 < longest_ * (1 - 1e-9))
      ++voxels_[a];
    grid_[a] =
        std::max<int64_t>(2, static_cast<int64_t>(std::ceil(static_cast<double>(layout.dims[a]) /
                                                            static_cast<double>(voxels_[a]))));
  }
  measure(scene, values);
  const Lighting& lighting = *scene.lighting;
  const Vec3d key = lighting.lights[0].toward;
  key_ = arriving(view.right * key.x + view.up * key.y - view.forward * key.z, 0);
  for (double& share : key_) share = 1 - lighting.shadows * (1 - share);
  open_.assign(extinction_.size(), 0.0);
  int directions = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const int moves = std::abs(x) + std::abs(y) + std::abs(z);
        if (moves != 1 && moves != 3) continue;
        ++directions;
        const std::vector<double> from =
            arriving({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)},
                     longest_ / 8 / finest_);
        for (size_t i = 0; i < from.size(); ++i) open_[i] += from[i];
      }
  for (double& share : open_)
    share = 1 - lighting.occlusion * (1 - std::min(1.0, 2 * share / directions));
}

double& ReferenceLight::texel(std::vector<double>& of, Vec3i at) const {
  return of[static_cast<size_t>((at.z * grid_.y + at.y) * grid_.x + at.x)];
}

double ReferenceLight::texelOr1(const std::vector<double>& of, Vec3i at) const {
  for (int a = 0; a < 3; ++a)
    if (at[a] < 0 || at[a] >= grid_[a]) return 1;
  return of[static_cast<size_t>((at.z * grid_.y + at.y) * grid_.x + at.x)];
}

double ReferenceLight::extinctionOf(const ReferenceScene& scene, const ReferenceValues& values,
                                    Vec3i voxel) const {
  const double value = values.at(toDouble(voxel));
  double sum = extinction(opacityAt(scene.transfer, value));
  const double range = scene.value_range.hi - scene.value_range.lo;
  for (const IsoSurface& surface : scene.transfer.surfaces) {
    const double level = surface.value - 1e-9 * range;
    if (std::isnan(value)) continue;
    // The plane that has the level, from the steepest way to it along each axis, and the distance
    // between planes of voxels along its normal.
    double squared = 0, squared_in_world = 0;
    for (int a = 0; a < 3; ++a) {
      double steepest = 0;
      for (const int way : {-1, 1}) {
        Vec3i next = voxel;
        next[a] += way;
        if (next[a] < 0 || next[a] >= layout_.dims[a]) continue;
        const double other = values.at(toDouble(next));
        const double change = value >= level ? value - other : other - value;
        if (change > steepest) steepest = change;
      }
      squared += steepest * steepest;
      squared_in_world += std::pow(steepest * finest_ / layout_.spacing[a], 2);
    }
    if (!(squared > 0)) continue;
    const double distance = std::abs(level - value) / std::sqrt(squared);
    const double nearness = std::max(0.0, 1 - distance), whole = extinction(surface.opacity);
    // All of the extinction up to 1 in proportion, and the rest by the third power.
    sum +=
        (std::min(whole, 1.0) * nearness + std::max(0.0, whole - 1) * 2 * std::pow(nearness, 3)) *
        std::sqrt(squared_in_world / squared);
  }
  return sum;
}

// The share of a texel around an index position that crop and clip planes leave.
double ReferenceLight::shownShare(const ReferenceScene& scene, Vec3d index) const {
  double share = 1;
  const auto cut = [&](Vec3d normal, double offset) {
    double width = 0;
    for (int a = 0; a < 3; ++a) width += std::abs(normal[a]) * static_cast<double>(voxels_[a]);
    share *= std::clamp(0.5 - (dot(normal, index) - offset) / width, 0.0, 1.0);
  };
  for (int a = 0; scene.crop && a < 3; ++a) {
    Vec3d normal;
    normal[a] = 1;
    if (scene.crop->hi[a] < layout_.dims[a])
      cut(normal, static_cast<double>(scene.crop->hi[a] - 1));
    if (scene.crop->lo[a] > 0) cut(normal * -1.0, -static_cast<double>(scene.crop->lo[a]));
  }
  for (const ReferenceClipPlane& plane : scene.clip_planes) {
    Vec3d normal;
    for (int a = 0; a < 3; ++a)
      normal[a] = dot(plane.normal, layout_.axes[static_cast<size_t>(a)]) * layout_.spacing[a];
    cut(normal, plane.offset - dot(plane.normal, layout_.origin));
  }
  return share;
}

void ReferenceLight::measure(const ReferenceScene& scene, const ReferenceValues& values) {
  const auto texels = static_cast<size_t>(grid_.x * grid_.y * grid_.z);
  extinction_.assign(texels, 0.0);
  std::vector<double> counts(texels, 0.0);
  Vec3i at;
  for (at.z = 0; at.z < layout_.dims.z; ++at.z)
    for (at.y = 0; at.y < layout_.dims.y; ++at.y)
      for (at.x = 0; at.x < layout_.dims.x; ++at.x) {
        texel(extinction_, at / voxels_) += extinctionOf(scene, values, at);
        texel(counts, at / voxels_) += 1;
      }
  for (at.z = 0; at.z < grid_.z; ++at.z)
    for (at.y = 0; at.y < grid_.y; ++at.y)
      for (at.x = 0; at.x < grid_.x; ++at.x) {
        Vec3d center;
        for (int a = 0; a < 3; ++a)
          center[a] = (static_cast<double>(at[a]) + 0.5) * static_cast<double>(voxels_[a]) - 0.5;
        const double count = texel(counts, at);
        texel(extinction_, at) *= count > 0 ? shownShare(scene, center) / count : 0;
      }
}

std::vector<double> ReferenceLight::arriving(Vec3d toward, double reach_vox) const {
  // One plane of texels toward the light, and its length.
  Vec3d pace = alongVoxels(layout_, normalized(toward)) / toDouble(voxels_);
  int main = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(pace[a]) > std::abs(pace[main])) main = a;
  const double length = 1 / std::abs(pace[main]) / finest_;
  pace = pace / std::abs(pace[main]);
  const double kept = reach_vox > 0 ? std::exp(-length / reach_vox) : 1;
  std::vector<double> in(extinction_.size()), out(extinction_.size()), result(extinction_.size());
  const auto last = [&](const std::vector<double>& of, Vec3i at) {
    double sum = 0;
    eachAround(toDouble(at) + pace,
               [&](Vec3i here, double weight) { sum += weight * texelOr1(of, here); });
    return sum;
  };
  for (int64_t n = 0; n < grid_[main]; ++n) {
    Vec3i lo{0, 0, 0}, hi = grid_;
    lo[main] = pace[main] > 0 ? grid_[main] - 1 - n : n;
    hi[main] = lo[main] + 1;
    Vec3i at;
    for (at.z = lo.z; at.z < hi.z; ++at.z)
      for (at.y = lo.y; at.y < hi.y; ++at.y)
        for (at.x = lo.x; at.x < hi.x; ++at.x) {
          const double arrives = last(out, at);
          texel(result, at) = last(in, at);
          texel(in, at) = arrives;
          const double passes = arrives * std::exp(-length * texelOr1(extinction_, at));
          texel(out, at) = 1 - (1 - passes) * kept;
        }
  }
  return result;
}

std::array<double, 2> ReferenceLight::at(Vec3d index) const {
  if (key_.empty()) return {1, 1};
  Vec3d place;
  for (int a = 0; a < 3; ++a)
    place[a] = std::clamp((index[a] + 0.5) / static_cast<double>(voxels_[a]) - 0.5, 0.0,
                          static_cast<double>(grid_[a] - 1));
  std::array<double, 2> shares{};
  eachAround(place, [&](Vec3i here, double weight) {
    for (int a = 0; a < 3; ++a) here[a] = std::min(here[a], grid_[a] - 1);
    shares[0] += weight * texelOr1(key_, here);
    shares[1] += weight * texelOr1(open_, here);
  });
  return shares;
}

}  // namespace sluice
