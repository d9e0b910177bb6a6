#include "src/render/light/coarse_extinction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "src/base/error.h"
#include "src/device/chunk_texels.h"
#include "src/render/camera/index_space.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {
namespace {

// A thread reads whole rows of the volume, of so many voxels across as chunks of files often have,
// and at most so many voxels at once.
constexpr int64_t kTileVoxels = 64, kMostVoxels = kMostCoarseVoxelsRead;

// The extinction of an opaque voxel is infinite: 2^-16 of the light always passes.
constexpr double kMostOfLength = 16 * std::numbers::ln2;

double extinctionOf(double opacity) {
  return opacity < 1 ? std::min(-std::log1p(-std::max(opacity, 0.0)), kMostOfLength)
                     : kMostOfLength;
}

// The opacity of a mean and a spread, see ExpectedLook. `exact`: without spread.
double expectedOpacity(const ExpectedLook& look, double mean, double spread, double exact) {
  const ValueRange values = look.device_range;
  const double span = values.hi - values.lo;
  if (!(span > 0) || !(spread > 0)) return exact;
  // Rows are spaced by the root of the spread, as ExpectedLook has them. Below the first row the
  // look blends into the exact one.
  const double row = std::sqrt(spread / span) * look.rows;
  const double at_row = std::clamp(row - 1, 0.0, look.rows - 1.0);
  const double at_entry =
      std::clamp((mean - values.lo) / span * (look.entries - 1), 0.0, look.entries - 1.0);
  const auto opacityAt = [&](int in_row, int entry) {
    const int at =
        std::min(in_row, look.rows - 1) * look.entries + std::min(entry, look.entries - 1);
    return static_cast<double>(look.rgba[4 * static_cast<size_t>(at) + 3]);
  };
  const int r = static_cast<int>(at_row), e = static_cast<int>(at_entry);
  const double lower = std::lerp(opacityAt(r, e), opacityAt(r, e + 1), at_entry - e);
  const double upper = std::lerp(opacityAt(r + 1, e), opacityAt(r + 1, e + 1), at_entry - e);
  return std::lerp(exact, std::lerp(lower, upper, at_row - r), std::min(row, 1.0));
}

// The level whose voxels are read.
struct ReadLevel {
  VolumeSource* source = nullptr;
  VolumeSource* spreads = nullptr;
  LevelPlacement placement;
};
ReadLevel levelFor(const TimeStep& step, const CoarseGrid& grid, MatterFrom from) {
  ReadLevel level{step.source, nullptr, {}};
  if (from == MatterFrom::kFinest) return level;
  const PyramidLayout pyramid = step.layout();
  for (size_t i = 0; i < step.coarser.size(); ++i) {
    const LevelPlacement& placement = pyramid.level(static_cast<int>(i) + 1).placement;
    // The coarsest level whose voxels are no wider than a texel of the light.
    for (int a = 0; a < 3; ++a)
      if (placement.scale[a] > static_cast<double>(grid.voxels[a]) + 1e-6) return level;
    level = {step.coarser[i].source, step.coarser[i].spreads, placement};
  }
  return level;
}

// The sums of a texel.
struct Sum {
  double extinction = 0;
  int64_t voxels = 0;
};

class Maker {
 public:
  Maker(const TimeStep& step, const Look& look, MatterFrom from, const StopToken& stop,
        const VoxelPlanes& planes)
      : step_(step),
        look_(look),
        stop_(stop),
        layout_(step.source->layout()),
        grid_(coarseGrid(layout_)),
        level_(levelFor(step, grid_, from)),
        level_dims_(level_.source->layout().dims),
        texels_(texelsAround(planes)),
        planes_(planesOn(level_.placement, planes)),
        voxel_lengths_(layout_.spacing * level_.placement.scale / finestSpacing(layout_)),
        type_(step.ranges->map.type) {
    // One number for each value of integers of up to 16 bits, so that the loop over voxels needs no
    // division; else one for each entry.
    const size_t values = type_ == DeviceType::kU8 ? 256 : type_ == DeviceType::kU16 ? 65536 : 0;
    const std::vector<float>& opacity = look.table.opacity();
    for (size_t i = 0; i < (values > 0 ? values : opacity.size()); ++i) {
      const size_t entry = values > 0 ? entryOf(static_cast<double>(i)) : i;
      extinctions_.push_back(static_cast<float>(extinctionOf(opacity[entry])));
    }
    // A surface takes its whole opacity at one meeting, whatever the step.
    for (const SurfaceLevel& surface : look.table.surfaces())
      meetings_.push_back(extinctionOf(surface.opacity));
  }

  CoarseExtinction make(WorkerPool& pool) {
    sums_.resize(static_cast<size_t>(grid_.count()));
    // Tiles of whole texels: no two threads have the same one.
    Vec3i side = texels_.size(), tiles{1, 1, 1};
    for (const int a : {1, 2}) {
      side[a] = std::max<int64_t>(1, kTileVoxels / grid_.voxels[a]);
      tiles[a] = (texels_.size()[a] + side[a] - 1) / side[a];
    }
    pool.parallelFor(tiles.y * tiles.z, [&](int64_t tile) {
      const Vec3i first = texels_.lo + Vec3i{0, tile % tiles.y, tile / tiles.y} * side;
      addVoxels({firstVoxelOf(first), firstVoxelOf(min(first + side, texels_.hi))});
    });
    CoarseExtinction result{grid_, {}};
    result.per_length.reserve(sums_.size());
    for (const Sum& sum : sums_)
      result.per_length.push_back(static_cast<float>(
          sum.voxels > 0 ? sum.extinction / static_cast<double>(sum.voxels) : 0));
    return result;
  }

 private:
  // The texels that the cells of the planes reach into: within() leaves nothing of the others.
  Box3 texelsAround(const VoxelPlanes& planes) const {
    Box3 texels = boxOf(grid_.texels);
    for (int a = 0; a < 3; ++a)
      if (const auto plane = planes[static_cast<size_t>(a)]) {
        texels.lo[a] = std::max<int64_t>(*plane - 1, 0) / grid_.voxels[a];
        texels.hi[a] = std::min((*plane + 1) / grid_.voxels[a] + 1, grid_.texels[a]);
      }
    return texels;
  }
  // The level's first voxel whose centre is not below the texel. Texels share out the voxels: each
  // is in one.
  Vec3i firstVoxelOf(Vec3i texel) const {
    const Vec3d begin = toDouble(texel * grid_.voxels) - Vec3d{0.5, 0.5, 0.5};
    const Vec3d at = level_.placement.levelFromFinest(begin);
    Vec3i voxel;
    for (int a = 0; a < 3; ++a)
      // The last texel has all that remains.
      voxel[a] = texel[a] >= grid_.texels[a]
                     ? level_dims_[a]
                     : std::clamp<int64_t>(static_cast<int64_t>(std::ceil(at[a] - 1e-9)), 0,
                                           level_dims_[a]);
    return voxel;
  }
  Vec3i texelOf(Vec3i voxel) const {
    const Vec3d at = level_.placement.finestFromLevel(toDouble(voxel)) + Vec3d{0.5, 0.5, 0.5};
    Vec3i texel;
    for (int a = 0; a < 3; ++a)
      texel[a] = std::clamp<int64_t>(
          static_cast<int64_t>(std::floor(at[a] / static_cast<double>(grid_.voxels[a]) + 1e-9)), 0,
          grid_.texels[a] - 1);
    return texel;
  }

  void addVoxels(const Box3& voxels) {
    if (voxels.empty()) return;
    if (voxels.count() <= kMostVoxels) {
      stop_.throwIfStopped();
      visitDeviceType(type_, [&](auto zero) {
        addRead<decltype(zero)>(voxels);
        return 0;
      });
      return;
    }
    const Vec3i size = voxels.size();
    // Along x only if rows are very long: whole rows are what a file stores together.
    const int axis = size.x > 8 * kTileVoxels ? 0 : size.z > 1 ? 2 : size.y > 1 ? 1 : 0;
    Box3 lower = voxels, upper = voxels;
    lower.hi[axis] = upper.lo[axis] = (voxels.lo[axis] + voxels.hi[axis]) / 2;
    addVoxels(lower);
    addVoxels(upper);
  }

  template <class Voxel>
  std::vector<Voxel> read(VolumeSource& source, const Box3& box) const {
    std::vector<Voxel> voxels(static_cast<size_t>(box.count()));
    DeviceReader(source).read(step_.time, {box, std::as_writable_bytes(std::span(voxels))});
    return voxels;
  }

  // Adds these voxels. Along an axis that shows one plane, its values stand for those of all.
  template <class Voxel>
  void addRead(const Box3& voxels) {
    // Surfaces look at the neighbours, too.
    Box3 box = voxels;
    if (!meetings_.empty())
      for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max<int64_t>(box.lo[a] - 1, 0);
        box.hi[a] = std::min(box.hi[a] + 1, level_dims_[a]);
      }
    for (int a = 0; a < 3; ++a)
      if (const auto plane = planes_[static_cast<size_t>(a)]) {
        box.lo[a] = std::clamp<int64_t>(*plane, 0, level_dims_[a] - 1);
        box.hi[a] = box.lo[a] + 1;
      }
    const std::vector<Voxel> values = read<Voxel>(*level_.source, box);
    std::vector<Voxel> spreads;  // or shares, of labels
    const ExpectedLook* expected = look_.look_up->expected.get();
    const bool has_labels = look_.table.labels();
    if (level_.spreads != nullptr && (expected != nullptr || has_labels))
      spreads = read<Voxel>(*level_.spreads, box);
    const Vec3i size = box.size();
    Vec3i steps{1, size.x, size.x * size.y};
    for (int a = 0; a < 3; ++a)
      if (planes_[static_cast<size_t>(a)]) steps[a] = 0;
    Vec3i at = voxels.lo;
    std::vector<size_t> texel_x;
    for (; at.x < voxels.hi.x; ++at.x) texel_x.push_back(static_cast<size_t>(texelOf(at).x));
    at.x = voxels.lo.x;
    for (at.z = voxels.lo.z; at.z < voxels.hi.z; ++at.z)
      for (at.y = voxels.lo.y; at.y < voxels.hi.y; ++at.y) {
        const Vec3i row = (at - box.lo) * steps, texel = texelOf(at);
        Sum* const sums =
            &sums_[static_cast<size_t>((texel.z * grid_.texels.y + texel.y) * grid_.texels.x)];
        auto i = static_cast<size_t>(row.x + row.y + row.z);
        for (size_t x = 0; x < texel_x.size(); ++x, i += static_cast<size_t>(steps.x)) {
          double extinction = extinctionAt(values[i]);
          if (!spreads.empty()) {
            // Back from the extinction to the opacity, over which the expected look is a mean.
            const double exact = -std::expm1(-extinction), second = static_cast<double>(spreads[i]);
            extinction =
                extinctionOf(has_labels ? exact * (1 - second / wholeShare(type_))
                                        : expectedOpacity(*expected, static_cast<double>(values[i]),
                                                          second, exact));
          }
          if (!meetings_.empty())
            extinction +=
                meetingsAt(values, i, steps, {at.x + static_cast<int64_t>(x), at.y, at.z});
          sums[texel_x[x]].extinction += extinction;
          ++sums[texel_x[x]].voxels;
        }
      }
  }

  size_t entryOf(double value) const { return static_cast<size_t>(look_.table.entryOf(value)); }
  template <class Voxel>
  double extinctionAt(Voxel value) const {
    if constexpr (std::is_integral_v<Voxel>) return extinctions_[value];
    // NaN lets light pass.
    if (value < kNoNumber) return 0;
    return extinctions_[entryOf(static_cast<double>(value))];
  }
  // The extinctions of the surfaces at voxel i of a box, of a voxel length. A surface counts for
  // the voxels less than a voxel away from it, the more the nearer it is, so that all of them
  // together have its area wherever it lies between them: in small volumes, whose texels are single
  // voxels, a surface that counted for whole voxels would be stairs, and its shadow ripples.
  template <class Voxel>
  double meetingsAt(const std::vector<Voxel>& values, size_t i, Vec3i steps, Vec3i voxel) const {
    const auto own = static_cast<double>(values[i]);
    if (own < kNoNumber) return 0;
    // The steepest ways up and down. At an edge only one side of the voxel has it.
    Vec3d rise, fall;
    const auto look = [&](int a, size_t at) {
      const auto other = static_cast<double>(values[at]);
      if (other < kNoNumber) return;
      rise[a] = std::max(rise[a], other - own);
      fall[a] = std::max(fall[a], own - other);
    };
    for (int a = 0; a < 3; ++a) {
      const auto step = static_cast<size_t>(steps[a]);
      if (voxel[a] > 0) look(a, i - step);
      if (voxel[a] + 1 < level_dims_[a]) look(a, i + step);
    }
    double sum = 0;
    for (size_t n = 0; n < meetings_.size(); ++n) {
      const double level = look_.table.surfaces()[n].level, away = std::abs(level - own);
      const Vec3d& slope = own < level ? rise : fall;
      const double a_voxel = length(slope);
      if (away < a_voxel)
        // The quotient accounts for voxels whose lengths differ between the axes.
        sum += shareOf(meetings_[n], 1 - away / a_voxel) * length(slope / voxel_lengths_) / a_voxel;
    }
    return sum;
  }

  // The part of a surface's extinction that a voxel takes. `nearness`: 1 - its distance in voxels.
  // The parts of all voxels on a line through the surface sum up to the whole, in the mean of all
  // places of the surface. Extinction above kEven lies closer to the surface: otherwise an opaque
  // surface would be in its own shadow, which shows as rings if the light falls flat on it.
  static double shareOf(double extinction, double nearness) {
    constexpr double kEven = 1;
    const double even = std::min(extinction, kEven);
    return even * nearness + (extinction - even) * 2 * nearness * nearness * nearness;
  }

  // Below it lies the stand-in for NaN.
  static constexpr double kNoNumber = -2e30;

  const TimeStep& step_;
  const Look& look_;
  const StopToken& stop_;
  const VolumeLayout& layout_;
  const CoarseGrid grid_;
  const ReadLevel level_;
  const Vec3i level_dims_;
  const Box3 texels_;          // those that are filled
  const VoxelPlanes planes_;   // of the level
  const Vec3d voxel_lengths_;  // of a voxel of the level, along each axis
  const DeviceType type_;
  std::vector<float> extinctions_;  // by value of integers, by entry of the table for floats
  std::vector<double> meetings_;    // by surface
  std::vector<Sum> sums_;
};

}  // namespace

CoarseGrid coarseGrid(const VolumeLayout& layout) {
  double longest = 0;
  for (int a = 0; a < 3; ++a)
    longest = std::max(longest, layout.spacing[a] * static_cast<double>(layout.dims[a]));
  const double pitch = longest / static_cast<double>(kMostLightTexels);
  CoarseGrid grid;
  for (int a = 0; a < 3; ++a) {
    // A rounding above a whole number must not make texels a voxel wider.
    grid.voxels[a] =
        std::max<int64_t>(1, static_cast<int64_t>(std::ceil(pitch / layout.spacing[a] - 1e-9)));
    // Two at least, so that samples have two texels to interpolate between.
    grid.texels[a] = std::max<int64_t>(2, (layout.dims[a] + grid.voxels[a] - 1) / grid.voxels[a]);
  }
  return grid;
}

void requireFollowedByLight(const TransferFunction& transfer, const VolumeLayout& volume) {
  if (transfer.gradients.empty()) return;
  // The gradients of all voxels would be needed, which the pass over tiles does not compute.
  failRequest(
      "{}: --shadows and --occlusion-light do not follow opacities that depend on gradients; "
      "leave out --modulate, or take a transfer function without gradients",
      volume.calledBy());
}

CoarseExtinction coarseExtinction(const TimeStep& step, const Look& look, MatterFrom from,
                                  WorkerPool& pool, const StopToken& stop,
                                  const VoxelPlanes& planes) {
  requireFollowedByLight(look.transfer, step.source->layout());
  return Maker(step, look, from, stop, planes).make(pool);
}

CoarseExtinction within(const CoarseExtinction& whole, const std::vector<ClipPlane>& shown) {
  CoarseExtinction result = whole;
  const CoarseGrid& grid = whole.grid;
  Vec3i at;
  size_t i = 0;
  for (at.z = 0; at.z < grid.texels.z; ++at.z)
    for (at.y = 0; at.y < grid.texels.y; ++at.y)
      for (at.x = 0; at.x < grid.texels.x; ++at.x, ++i) {
        double share = 1;
        for (const ClipPlane& half : shown) {
          double width = 0;  // of the texel, across the plane
          for (int a = 0; a < 3; ++a)
            width += std::abs(half.normal[a]) * static_cast<double>(grid.voxels[a]);
          const double beyond = dot(half.normal, grid.centerOf(at)) - half.offset;
          // The share in front of the plane, by the width that the texel has across it.
          share *= std::clamp(0.5 - beyond / width, 0.0, 1.0);
        }
        result.per_length[i] = static_cast<float>(result.per_length[i] * share);
      }
  return result;
}

}  // namespace sluice
