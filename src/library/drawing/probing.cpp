#include "src/library/drawing/probing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "src/base/error.h"
#include "src/classify/blocks/visible_cells.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

// The share of light taken away from which on the matter in front hides what is behind.
constexpr double kHidden = 0.5;
// Less than this in all is invisible.
constexpr double kVisible = 0.02;
constexpr double kSamplesAVoxel = 2;

struct Totals {
  double lo, hi;
};

// Values at places of the volume, with the block of the last one at hand.
class Values {
 public:
  Values(Session& session, const TimeStep& step) : session_(session), step_(step) {}

  // The range of all voxels of the cell's block; nothing is read.
  Totals rangeAround(Vec3i cell) {
    const SliceRanges& ranges = *step_.ranges;
    const auto held = heldAt(cell);
    Totals totals{ranges.background, ranges.background};
    if (held)
      visitDeviceType(ranges.map.type, [&](auto zero) {
        const auto range = ranges.totalsAs<decltype(zero)>()[*held];
        totals = {static_cast<double>(range.lo), static_cast<double>(range.hi)};
        return 0;
      });
    const double a = ranges.map.valueOf(totals.lo), b = ranges.map.valueOf(totals.hi);
    return {std::min(a, b), std::max(a, b)};
  }

  // Linear between the eight voxels around an index position. Requires: within the volume.
  double at(Vec3d index) {
    const SliceRanges& ranges = *step_.ranges;
    const Vec3i cell = cellOf(index);
    if (!heldAt(cell)) return ranges.map.valueOf(ranges.background);
    load(cell);
    double value = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3i voxel = cell + Vec3i{corner & 1, (corner >> 1) & 1, corner >> 2};
      double weight = 1;
      for (int a = 0; a < 3; ++a) {
        const double part = index[a] - static_cast<double>(cell[a]);
        weight *= voxel[a] > cell[a] ? part : 1 - part;
      }
      if (weight > 0) value += weight * deviceAt(voxel);
    }
    return ranges.map.valueOf(value);
  }

  // The cell that an index position lies in.
  Vec3i cellOf(Vec3d index) const {
    Vec3i cell;
    for (int a = 0; a < 3; ++a)
      cell[a] = std::clamp(static_cast<int64_t>(std::floor(index[a])), int64_t{0},
                           std::max<int64_t>(0, step_.ranges->layout.dims[a] - 2));
    return cell;
  }

 private:
  int64_t blockOf(Vec3i cell) const {
    const BlockLayout& layout = step_.ranges->layout;
    const int64_t cells = layout.cells();
    return layout.idOf({cell.x / cells, cell.y / cells, cell.z / cells});
  }
  // Its position among the held ones.
  std::optional<size_t> heldAt(Vec3i cell) {
    const int64_t block = blockOf(cell);
    if (block != held_block_) {
      const auto& blocks = step_.ranges->blocks;
      const auto found = std::lower_bound(blocks.begin(), blocks.end(), block);
      held_block_ = block;
      held_.reset();
      if (found != blocks.end() && *found == block)
        held_ = static_cast<size_t>(found - blocks.begin());
    }
    return held_;
  }
  void load(Vec3i cell) {
    const BlockName key{.time = step_.time, .block = blockOf(cell)};
    if (block_ != nullptr && key == key_) return;
    block_.reset();
    block_ = session_.readBlocks(std::span(&key, 1)).front();
    key_ = key;
  }
  double deviceAt(Vec3i voxel) const {
    return visitDeviceType(block_->type, [&](auto zero) {
      auto stored = zero;
      std::memcpy(&stored, block_->at(voxel), sizeof stored);
      return static_cast<double>(stored);
    });
  }

  Session& session_;
  const TimeStep& step_;
  int64_t held_block_ = -1;
  std::optional<size_t> held_;
  BlockName key_;
  VolumeBlockPtr block_;
};

// A ray in index space: origin + t * direction, t in world units along the view's depth.
struct Ray {
  Vec3d origin, direction;
  double begin = 0, end = 0;  // inside the visible part
  double world_length = 1;    // length of a unit of t along the ray
};

// Cuts the ray to the part where normal * p <= offset.
void clip(Ray& ray, Vec3d normal, double offset) {
  const double slope = dot(normal, ray.direction), left = offset - dot(normal, ray.origin);
  if (std::abs(slope) < 1e-15) {
    if (left < 0) ray.end = ray.begin;
  } else if (slope > 0) {
    ray.end = std::min(ray.end, left / slope);
  } else {
    ray.begin = std::max(ray.begin, left / slope);
  }
}

Ray rayOf(const ProbeRequest& request, const VolumeLayout& layout) {
  const View& view = request.view;
  const double u = 2 * request.right - 1, v = 1 - 2 * request.down;
  const double aspect = static_cast<double>(view.size.width) / view.size.height;
  const Vec3d side =
      view.right * (u * aspect * view.half_height) + view.up * (v * view.half_height);
  const bool perspective = view.projection == Projection::kPerspective;
  const Vec3d from = perspective ? view.eye : view.eye + side;
  const Vec3d along = perspective ? view.forward + side : view.forward;
  constexpr double kFar = 1e30;
  Ray world{from, along, perspective ? 0 : -kFar, kFar};
  for (const WorldPlane& plane : request.options.clip_planes)
    clip(world, plane.normal, plane.offset);
  Ray ray{indexFromWorld(layout, from), indexFromWorldDirection(layout, along), world.begin,
          world.end, length(along)};
  const Box3 cells = cropCells(request.options, layout.dims);
  for (int a = 0; a < 3; ++a) {
    Vec3d normal{0, 0, 0};
    normal[a] = 1;
    clip(ray, normal, static_cast<double>(cells.hi[a]));
    clip(ray, normal * -1.0, -static_cast<double>(cells.lo[a]));
  }
  return ray;
}

}  // namespace

std::optional<VoxelProbe> probeAlong(const ProbeRequest& request, Session& session,
                                     const TimeStep& step, const StopToken& stop) {
  const VolumeLayout& layout = step.source->layout();
  const Ray ray = rayOf(request, layout);
  const double voxels = length(ray.direction);  // a unit of t
  if (!(ray.end > ray.begin) || !(voxels > 0)) return std::nullopt;
  const double along = 1 / (kSamplesAVoxel * voxels);  // units of t per sample
  const double lengths = along * ray.world_length / finestSpacing(layout);
  const ModeTraits& traits = traitsOf(request.options.mode);
  const bool composite = traits.hides;
  const bool least = traits.combining == Combining::kLeast;
  Values values(session, step);
  double through = 1, most = composite ? 0 : -std::numeric_limits<double>::infinity();
  std::optional<VoxelProbe> found;
  std::optional<double> last;  // the value before, on the way through cells that may show something
  const auto count = static_cast<int64_t>(std::min((ray.end - ray.begin) / along, 1e8));
  for (int64_t i = 0; i <= count; ++i) {
    stop.throwIfStopped();
    const Vec3d index =
        ray.origin + ray.direction * (ray.begin + (static_cast<double>(i) + 0.5) * along);
    const Totals around = values.rangeAround(values.cellOf(index));
    if (composite && !anyOpacity(request.transfer, around.lo, around.hi)) {
      last.reset();
      continue;
    }
    const double value = values.at(max(index, Vec3d{0, 0, 0}));
    if (!last && !request.transfer.surfaces.empty())
      last = values.at(max(index - ray.direction * along, Vec3d{0, 0, 0}));
    double weight = least ? -value : value;
    if (composite) {
      double clear = std::pow(1 - opacityAt(request.transfer, value), lengths);
      for (const IsoSurface& surface : request.transfer.surfaces)
        if (last && (*last >= surface.value) != (value >= surface.value))
          clear *= 1 - surface.opacity;
      last = value;
      const double opacity = 1 - clear;
      weight = through * opacity;
      through *= 1 - opacity;
    }
    if (weight > most) {
      most = weight;
      const Vec3d world = worldFromIndex(layout, index);
      found = VoxelProbe{{index.x, index.y, index.z}, {world.x, world.y, world.z}, value};
    }
    if (composite && through < kHidden) break;
  }
  if (composite && 1 - through < kVisible) return std::nullopt;
  return found;
}

SliceValues sliceOf(const SliceOptions& slice, Session& session, const TimeStep& step,
                    const StopToken& stop) {
  const SliceRanges& ranges = *step.ranges;
  const BlockLayout& layout = ranges.layout;
  if (slice.axis < 0 || slice.axis > 2) fail("slice of axis {}: must be 0, 1 or 2", slice.axis);
  if (slice.at < 0 || slice.at >= layout.dims[slice.axis])
    fail("slice {} of axis {}: the volume has {}, counted from 0", slice.at, slice.axis,
         layout.dims[slice.axis]);
  if (slice.most < 1) fail("slice of {} values a side: must be at least 1", slice.most);
  const int across = slice.axis == 0 ? 1 : 0, down = slice.axis == 2 ? 1 : 2;
  const int64_t longest = std::max(layout.dims[across], layout.dims[down]);
  SliceValues result;
  result.every = (longest + slice.most - 1) / slice.most;
  result.width = static_cast<int>((layout.dims[across] + result.every - 1) / result.every);
  result.height = static_cast<int>((layout.dims[down] + result.every - 1) / result.every);
  const auto background = static_cast<float>(ranges.map.valueOf(ranges.background));
  result.values.assign(static_cast<size_t>(result.width) * static_cast<size_t>(result.height),
                       background);
  const auto cellOf = [&](int axis, int64_t voxel) {
    return std::min(voxel, std::max<int64_t>(0, layout.dims[axis] - 2)) / layout.cells();
  };
  Vec3i at;
  at[slice.axis] = cellOf(slice.axis, slice.at);
  for (at[down] = 0; at[down] < layout.grid[down]; ++at[down]) {
    for (at[across] = 0; at[across] < layout.grid[across]; ++at[across]) {
      stop.throwIfStopped();
      const int64_t block = layout.idOf(at);
      if (!std::binary_search(ranges.blocks.begin(), ranges.blocks.end(), block)) continue;
      const BlockName key{.time = slice.time, .block = block};
      const VolumeBlockPtr voxels = session.readBlocks(std::span(&key, 1)).front();
      const Box3 cells = layout.ownedCells(at);
      // Neighbours share a plane of voxels: both have the same.
      const auto first = [&](int axis) {
        return (cells.lo[axis] + result.every - 1) / result.every;
      };
      for (int64_t y = first(down); y * result.every <= cells.hi[down]; ++y) {
        for (int64_t x = first(across); x * result.every <= cells.hi[across]; ++x) {
          Vec3i voxel;
          voxel[slice.axis] = slice.at;
          voxel[across] = x * result.every;
          voxel[down] = y * result.every;
          const double device = visitDeviceType(voxels->type, [&](auto zero) {
            auto stored = zero;
            std::memcpy(&stored, voxels->at(voxel), sizeof stored);
            return static_cast<double>(stored);
          });
          result.values[static_cast<size_t>(y) * static_cast<size_t>(result.width) +
                        static_cast<size_t>(x)] = static_cast<float>(ranges.map.valueOf(device));
        }
      }
    }
  }
  return result;
}

}  // namespace sluice
