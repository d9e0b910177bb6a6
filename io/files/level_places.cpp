#include "io/files/level_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace sluice {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};
// Scales are often the ratio of two rounded numbers.
constexpr double kSlack = 1e-3;

double factorOfShapes(int64_t finest, int64_t level) {
  const auto ratio = static_cast<double>(finest) / static_cast<double>(level);
  const auto whole = static_cast<int64_t>(std::lround(ratio));
  // Levels round an odd number of voxels up or down.
  const bool fits = whole >= 1 && (finest / whole == level || ceilDiv(finest, whole) == level);
  return fits ? static_cast<double>(whole) : ratio;
}

// Voxels of a box as doubles, x fastest.
struct Values {
  Box3 box;
  std::vector<double> values;

  double at(Vec3i p) const {
    const Vec3i local = p - box.lo, size = box.size();
    return values[static_cast<size_t>((local.z * size.y + local.y) * size.x + local.x)];
  }
};

Values readValues(VolumeSource& source, const Box3& box) {
  Values read{box, {}};
  read.values.resize(static_cast<size_t>(box.count()));
  visitVoxelType(source.layout().type, [&](auto tag) {
    std::vector<decltype(tag)> voxels(read.values.size());
    source.readRegion(0, box, std::as_writable_bytes(std::span(voxels)));
    for (size_t i = 0; i < voxels.size(); ++i) {
      const auto value = static_cast<double>(voxels[i]);
      // One voxel that is no number would spoil the sum of all.
      read.values[i] = std::isfinite(value) ? value : 0;
    }
  });
  return read;
}

constexpr int64_t kCellSide = 12;     // voxels that are compared, a side
constexpr int64_t kSearchSide = 128;  // voxels a side in the coarse level, around its middle
constexpr int64_t kMostFineSide = 256;

// The cell of the coarse level in which its voxels differ most; its border is left out.
Box3 busiestCell(const Values& coarse) {
  const Vec3i size = coarse.box.size();
  Box3 best = coarse.box;
  double most = -1;
  const Vec3i side = min(Vec3i{kCellSide, kCellSide, kCellSide}, size);
  for (int64_t z = 0; z + side.z <= size.z; z += side.z)
    for (int64_t y = 0; y + side.y <= size.y; y += side.y)
      for (int64_t x = 0; x + side.x <= size.x; x += side.x) {
        const Vec3i lo = coarse.box.lo + Vec3i{x, y, z};
        double sum = 0, squares = 0;
        for (int64_t k = 0; k < side.z; ++k)
          for (int64_t j = 0; j < side.y; ++j)
            for (int64_t i = 0; i < side.x; ++i) {
              const double value = coarse.at(lo + Vec3i{i, j, k});
              sum += value;
              squares += value * value;
            }
        const auto count = static_cast<double>(volume(side));
        const double variance = squares / count - (sum / count) * (sum / count);
        if (variance <= most) continue;
        most = variance;
        best = {lo, lo + side};
      }
  return best;
}

// Weights of the fine voxels along an axis that a coarse one stands for.
struct Weights {
  int64_t first = 0;
  std::vector<double> of;
};

// Weights of the voxels that an interval of `width` around `middle` covers; voxel i covers i - 0.5
// to i + 0.5. A width of 1 is linear interpolation.
Weights boxWeights(double middle, double width) {
  const double lo = middle - width / 2, hi = middle + width / 2;
  Weights weights;
  weights.first = static_cast<int64_t>(std::floor(lo + 0.5));
  for (int64_t i = weights.first; static_cast<double>(i) - 0.5 < hi; ++i) {
    const double covered =
        std::min(hi, static_cast<double>(i) + 0.5) - std::max(lo, static_cast<double>(i) - 0.5);
    weights.of.push_back(std::max(0.0, covered) / width);
  }
  return weights;
}

double weighted(const Values& fine, const std::array<Weights, 3>& weights) {
  const auto& [wx, wy, wz] = weights;
  double sum = 0;
  for (size_t k = 0; k < wz.of.size(); ++k)
    for (size_t j = 0; j < wy.of.size(); ++j)
      for (size_t i = 0; i < wx.of.size(); ++i) {
        const double weight = wx.of[i] * wy.of[j] * wz.of[k];
        if (weight == 0) continue;
        const Vec3i at{wx.first + static_cast<int64_t>(i), wy.first + static_cast<int64_t>(j),
                       wz.first + static_cast<int64_t>(k)};
        sum += weight * fine.at(max(fine.box.lo, min(at, fine.box.hi - Vec3i{1, 1, 1})));
      }
  return sum;
}

// The fine voxels around a box of coarse ones, wherever the coarse voxels lie among them.
Box3 finerAround(const Box3& coarse, Vec3d factor, Vec3i fine_dims) {
  Box3 around;
  for (int a = 0; a < 3; ++a) {
    const double first = factor[a] * static_cast<double>(coarse.lo[a]) - factor[a] - 1;
    const double last = factor[a] * static_cast<double>(coarse.hi[a]) + factor[a] + 1;
    around.lo[a] = std::max<int64_t>(0, static_cast<int64_t>(std::floor(first)));
    around.hi[a] = std::min(fine_dims[a], static_cast<int64_t>(std::ceil(last)));
  }
  return around;
}

// Squares of the differences between coarse voxels and the values that the fine ones give, as means
// of several voxels or as single ones.
struct Misfit {
  double of_means = 0, of_points = 0;

  // Whichever way the level was made fits better.
  double least() const { return std::min(of_means, of_points); }
};

// Adds the misfit of the coarse voxels of a layer of cells.
void addMisfit(const Values& fine, const Values& coarse, const Box3& layer, Vec3d factor,
               Vec3d offset, Misfit& sum) {
  for (int64_t z = layer.lo.z; z < layer.hi.z; ++z)
    for (int64_t y = layer.lo.y; y < layer.hi.y; ++y)
      for (int64_t x = layer.lo.x; x < layer.hi.x; ++x) {
        const Vec3d middle = offset + factor * toDouble({x, y, z});
        std::array<Weights, 3> means, points;
        for (int a = 0; a < 3; ++a) {
          means[static_cast<size_t>(a)] = boxWeights(middle[a], factor[a]);
          points[static_cast<size_t>(a)] = boxWeights(middle[a], 1);
        }
        const double found = coarse.at({x, y, z});
        sum.of_means += std::pow(found - weighted(fine, means), 2);
        sum.of_points += std::pow(found - weighted(fine, points), 2);
      }
}

}  // namespace

Vec3d levelFactor(const LevelClaim& finest, const LevelClaim& level) {
  Vec3d factor;
  for (int a = 0; a < 3; ++a)
    factor[a] = finest.scale && level.scale ? (*level.scale)[a] / (*finest.scale)[a]
                                            : factorOfShapes(finest.dims[a], level.dims[a]);
  return factor;
}

std::string faultOfLevel(const LevelClaim& finest, const LevelClaim& level) {
  const Vec3d factor = levelFactor(finest, level);
  bool is_coarser = false;
  for (int a = 0; a < 3; ++a) {
    if (!(factor[a] >= 1 - kSlack))
      return fmt::format("along {} it is finer than the first level by its {}", kAxisNames[a],
                         level.scale ? "scale" : "shape");
    const auto voxels = static_cast<double>(finest.dims[a]);
    const double covered = factor[a] * static_cast<double>(level.dims[a]);
    // Rounded up or down, a level covers the volume to less than one of its voxels.
    if (std::abs(covered - voxels) >= factor[a] + kSlack * voxels)
      return fmt::format(
          "its scale is {:g} times the first level's along {}, but by its shape it should be {:g} "
          "({} voxels for {})",
          factor[a], kAxisNames[a], voxels / static_cast<double>(level.dims[a]), level.dims[a],
          finest.dims[a]);
    is_coarser = is_coarser || factor[a] > 1 + kSlack;
  }
  return is_coarser ? "" : "it is as fine as the first level";
}

Vec3d offsetOf(VoxelOrigin origin, Vec3d factor) {
  return origin == VoxelOrigin::kCentre ? Vec3d{} : (factor - Vec3d{1, 1, 1}) * 0.5;
}

std::optional<VoxelOrigin> originOf(VolumeSource& fine, VolumeSource& coarse, Vec3d factor) {
  const Vec3i dims = coarse.layout().dims;
  const Vec3i side = min(dims, Vec3i{kSearchSide, kSearchSide, kSearchSide});
  const Vec3i lo = (dims - side) / 2;
  const Values searched = readValues(coarse, {lo, lo + side});
  const Box3 cell = busiestCell(searched);
  const Box3 around = finerAround(cell, factor, fine.layout().dims);
  for (int a = 0; a < 3; ++a)
    if (around.hi[a] - around.lo[a] > kMostFineSide || around.hi[a] <= around.lo[a])
      return std::nullopt;
  Misfit corner_sum, centre_sum;
  // One layer of coarse voxels at a time: all fine voxels of a cell would take up to 134 MB.
  for (Box3 layer = cell; layer.lo.z < cell.hi.z; ++layer.lo.z) {
    layer.hi.z = layer.lo.z + 1;
    Box3 finer_box = around;
    const Box3 of_layer = finerAround(layer, factor, fine.layout().dims);
    // A level may be rounded up beyond the last fine voxel, which then stands for those beyond it.
    finer_box.lo.z = std::min(of_layer.lo.z, around.hi.z - 1);
    finer_box.hi.z = std::max(of_layer.hi.z, finer_box.lo.z + 1);
    const Values finer = readValues(fine, finer_box);
    addMisfit(finer, searched, layer, factor, offsetOf(VoxelOrigin::kCorner, factor), corner_sum);
    addMisfit(finer, searched, layer, factor, offsetOf(VoxelOrigin::kCentre, factor), centre_sum);
  }
  const double corner = corner_sum.least(), centre = centre_sum.least();
  constexpr double kClearly = 0.7;
  if (corner < kClearly * centre) return VoxelOrigin::kCorner;
  if (centre < kClearly * corner) return VoxelOrigin::kCentre;
  return std::nullopt;
}

std::string findOrigin(VolumeSource& finest, std::span<CoarserLevel> levels) {
  constexpr int64_t kLeastSide = 8;
  size_t at = levels.size() - 1;
  const auto leastSide = [&](size_t i) {
    const Vec3i d = levels[i].source->layout().dims;
    return std::min({d.x, d.y, d.z});
  };
  // The coarsest pair with enough voxels to compare takes the least reading.
  while (at > 0 && leastSide(at) < kLeastSide) --at;
  VolumeSource& fine = at == 0 ? finest : *levels[at - 1].source;
  const Vec3d finer = at == 0 ? Vec3d{1, 1, 1} : levels[at - 1].placement.scale;
  const auto origin = originOf(fine, *levels[at].source, levels[at].placement.scale / finer);
  for (CoarserLevel& level : levels)
    level.placement.offset = offsetOf(origin.value_or(VoxelOrigin::kCorner), level.placement.scale);
  return fmt::format(
      "its levels have no translation; comparing levels {} and {} {}", at, at + 1,
      !origin ? "does not tell where their voxels lie; sluice assumes a common corner"
      : *origin == VoxelOrigin::kCorner ? "shows voxels that begin at a common corner"
                                        : "shows first voxels with a common centre");
}

}  // namespace sluice
