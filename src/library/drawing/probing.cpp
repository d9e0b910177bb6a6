#include "src/library/drawing/probing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "src/base/error.h"
#include "src/classify/blocks/visible_cells.h"
#include "src/render/camera/index_space.h"
#include "src/volume/voxels/device_voxel.h"

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

double deviceValue(const VolumeBlock& block, Vec3i voxel) {
  return visitDeviceType(block.type, [&](auto zero) {
    auto stored = zero;
    std::memcpy(&stored, block.at(voxel), sizeof stored);
    return static_cast<double>(stored);
  });
}

// A device voxel as its value, with the stand-ins of device_voxel.h undone: NaN for no number, and
// infinities.
double storedValue(const ValueMap& map, double device) {
  if (device == double{kNotANumber}) return std::numeric_limits<double>::quiet_NaN();
  if (std::abs(device) == double{kLargest})
    device = std::copysign(std::numeric_limits<double>::infinity(), device);
  return map.valueOf(device);
}

// Values at places of the volume, with the block of the last one at hand.
class Values {
 public:
  Values(Session& session, const TimeStep& step) : session_(session), step_(step) {}

  // The range of all voxels of the cell's block; nothing is read.
  Totals rangeAround(Vec3i cell) {
    const SliceRanges& ranges = *step_.ranges;
    const auto held = heldAt(cell);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!is_known_) return {-kInfinity, kInfinity};
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

  // Linear between the eight voxels around an index position, as pictures are drawn; NaN if a voxel
  // among them is no number: such a sample shows nothing. Requires: within the volume.
  double at(Vec3d index) {
    const double device = interpolated(index, [](double voxel) { return voxel; });
    // Nothing else lies below the infinities' stand-in.
    if (device < -2 * double{kLargest}) return std::numeric_limits<double>::quiet_NaN();
    return step_.ranges->map.valueOf(device);
  }
  // The same between the stored values: infinite beside an infinite voxel.
  double storedAt(Vec3d index) {
    const ValueMap& map = step_.ranges->map;
    return interpolated(index, [&](double voxel) { return storedValue(map, voxel); });
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
  template <class ValueOf>
  double interpolated(Vec3d index, const ValueOf& value_of) {
    const Vec3i cell = cellOf(index);
    if (!heldAt(cell) && is_known_) return value_of(step_.ranges->background);
    load(cell);
    double value = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3i voxel = cell + Vec3i{corner & 1, (corner >> 1) & 1, corner >> 2};
      double weight = 1;
      for (int a = 0; a < 3; ++a) {
        const double part = index[a] - static_cast<double>(cell[a]);
        weight *= voxel[a] > cell[a] ? part : 1 - part;
      }
      if (weight > 0) value += weight * value_of(deviceValue(*block_, voxel));
    }
    return value;
  }
  int64_t blockOf(Vec3i cell) const {
    const BlockLayout& layout = step_.ranges->layout;
    const int64_t cells = layout.cells();
    return layout.idOf({cell.x / cells, cell.y / cells, cell.z / cells});
  }
  // Its position among the held ones. Sets is_known_.
  std::optional<size_t> heldAt(Vec3i cell) {
    const int64_t block = blockOf(cell);
    if (block != held_block_) {
      const auto& blocks = step_.ranges->blocks;
      const auto found = std::lower_bound(blocks.begin(), blocks.end(), block);
      held_block_ = block;
      held_.reset();
      if (found != blocks.end() && *found == block)
        held_ = static_cast<size_t>(found - blocks.begin());
      is_known_ = held_ || step_.ranges->isKnown(block);
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

  Session& session_;
  const TimeStep& step_;
  int64_t held_block_ = -1;
  std::optional<size_t> held_;
  bool is_known_ = true;  // of the same block: what values it has
  BlockName key_;
  VolumeBlockPtr block_;
};

// The level that the values of a slice are taken from.
struct SlicedLevel {
  int number = 0;
  BlockLayout layout;
  LevelPlacement placement = {};
  const SliceRanges* ranges = nullptr;  // null: nothing is known

  // Values along an axis, from `begin` to `end`, that lie in one block.
  struct Run {
    int64_t block = 0;
    int begin = 0, end = 0;
  };
  // The level's voxel that is nearest to a finest one.
  int64_t voxelAt(int axis, int64_t finest) const {
    const double at =
        (static_cast<double>(finest) - placement.offset[axis]) / placement.scale[axis];
    return std::clamp<int64_t>(std::llround(at), 0, layout.dims[axis] - 1);
  }
  // Neighbours share a plane of voxels: both have the same.
  int64_t blockOf(int axis, int64_t voxel) const {
    return std::min(voxel, std::max<int64_t>(0, layout.dims[axis] - 2)) / layout.cells();
  }
  std::vector<Run> runs(int axis, int64_t every, int count) const {
    std::vector<Run> all;
    for (int i = 0; i < count; ++i) {
      const int64_t block = blockOf(axis, voxelAt(axis, i * every));
      if (all.empty() || all.back().block != block) all.push_back({block, i, i});
      all.back().end = i + 1;
    }
    return all;
  }
  double background() const { return ranges == nullptr ? 0 : ranges->background; }
  // Whether the block may have other values than the background.
  bool mayDiffer(int64_t block) const {
    return ranges == nullptr || std::ranges::binary_search(ranges->blocks, block) ||
           !ranges->isKnown(block);
  }
};

// The finest level; but of a volume whose finest level was not read, the coarsest level that has as
// many values: otherwise a slice would read thousands of blocks of which it shows little.
SlicedLevel slicedLevel(const TimeStep& step, int64_t every) {
  SlicedLevel found{0, step.ranges->layout, {}, step.ranges.get()};
  if (step.ranges->unknown.empty()) return found;
  const PyramidLayout pyramid = step.layout();
  for (int number = 1; number < pyramid.levels(); ++number) {
    const LevelLayout& level = pyramid.level(number);
    const CoarserStep& coarser = step.coarser[static_cast<size_t>(number) - 1];
    const Vec3d scale = level.placement.scale;
    const bool are_means = coarser.valuesShown() == LevelValues::kMeans ||
                           coarser.valuesShown() == LevelValues::kUnknown;
    if (!are_means || std::max({scale.x, scale.y, scale.z}) > static_cast<double>(every)) break;
    found = {number, level.blocks, level.placement, coarser.ranges.get()};
  }
  return found;
}

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
  const double aspect = view.size.aspect();
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
  const bool attenuated = traits.combining == Combining::kAttenuated;
  const double first = request.transfer.colors.front().value;
  const double span = request.transfer.colors.back().value - first;
  double in_front = 0;  // attenuated: the integral over the way so far
  const VoxelPlanes planes = planesOf(request.options.crop, layout.dims);
  Values values(session, step);
  double through = 1, most = composite ? 0 : -std::numeric_limits<double>::infinity();
  std::optional<VoxelProbe> found;
  Vec3d met{0, 0, 0};          // where that is
  std::optional<double> last;  // the value before, on the way through cells that may show something
  // Bounds the loop for a ray that a tiny voxel size makes endless.
  const auto count = static_cast<int64_t>(std::min((ray.end - ray.begin) / along, 1e8));
  for (int64_t i = 0; i <= count; ++i) {
    stop.throwIfStopped();
    const Vec3d index =
        ray.origin + ray.direction * (ray.begin + (static_cast<double>(i) + 0.5) * along);
    const Totals around = values.rangeAround(values.cellOf(index));
    // Interpolated values stay within the range of the cell's block, so nothing of it can show.
    if (composite && !anyOpacity(request.transfer, around.lo, around.hi)) {
      last.reset();
      continue;
    }
    const auto shownAt = [&](Vec3d place) {
      // A plane that is drawn one voxel thick has its values all through.
      for (int a = 0; a < 3; ++a)
        if (const auto plane = planes[static_cast<size_t>(a)])
          place[a] = static_cast<double>(*plane);
      return max(place, Vec3d{0, 0, 0});
    };
    const double value = values.at(shownAt(index));
    if (std::isnan(value)) {
      last.reset();
      continue;
    }
    // A surface is met between two samples, so the one before a stretch that was skipped is read
    // after all.
    if (!last && !request.transfer.surfaces.empty())
      last = values.at(shownAt(index - ray.direction * along));
    double weight = least ? -value : value;
    if (attenuated) {
      // The same weight as the device's attenuated mode: a value counts by its place in the range,
      // less by what lies in front.
      const double place = span > 0 ? std::clamp((value - first) / span, 0.0, 1.0) : 0;
      const bool shows = opacityAt(request.transfer, value) > 0;
      weight = shows ? place * std::exp(-request.transfer.attenuation * in_front) : -1;
      if (shows) in_front += place * lengths;
    }
    if (composite) {
      double clear = std::pow(1 - opacityAt(request.transfer, value), lengths);
      // The surface lies between the two samples if they are on either side of its value.
      for (const IsoSurface& surface : request.transfer.surfaces)
        if (last && !std::isnan(*last) && (*last >= surface.value) != (value >= surface.value))
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
      met = shownAt(index);
    }
    if (composite && through < kHidden) break;
  }
  if (composite && 1 - through < kVisible) return std::nullopt;
  if (found) {
    const double stored = values.storedAt(met);
    // Pictures are drawn with a finite stand-in for infinities; people are told the value of the
    // file.
    if (std::isinf(stored)) found->value = stored;
  }
  return found;
}

SliceValues sliceOf(const SliceOptions& slice, Session& session, const TimeStep& step,
                    const StopToken& stop) {
  const BlockLayout& layout = step.ranges->layout;
  if (slice.axis < 0 || slice.axis > 2)
    failRequest("slice of axis {}: must be 0, 1 or 2", slice.axis);
  if (slice.at < 0 || slice.at >= layout.dims[slice.axis])
    failRequest("slice {} of axis {}: the volume has {}, counted from 0", slice.at, slice.axis,
                layout.dims[slice.axis]);
  if (slice.most < 1) failRequest("slice of {} values a side: must be at least 1", slice.most);
  const int across = slice.axis == 0 ? 1 : 0, down = slice.axis == 2 ? 1 : 2;
  const int64_t longest = std::max(layout.dims[across], layout.dims[down]);
  SliceValues result;
  // Every so many voxels, so that the longer side has at most `most` values.
  result.every = (longest + slice.most - 1) / slice.most;
  result.width = static_cast<int>((layout.dims[across] + result.every - 1) / result.every);
  result.height = static_cast<int>((layout.dims[down] + result.every - 1) / result.every);
  const SlicedLevel level = slicedLevel(step, result.every);
  const ValueMap& map = step.ranges->map;
  result.values.assign(static_cast<size_t>(result.width) * static_cast<size_t>(result.height),
                       static_cast<float>(storedValue(map, level.background())));
  const std::vector<SlicedLevel::Run> columns = level.runs(across, result.every, result.width);
  Vec3i voxel;
  voxel[slice.axis] = level.voxelAt(slice.axis, slice.at);
  // Block by block, so that each is asked for once, whatever its number of values.
  for (const SlicedLevel::Run& rows : level.runs(down, result.every, result.height))
    for (const SlicedLevel::Run& run : columns) {
      stop.throwIfStopped();
      Vec3i index;
      index[across] = run.block;
      index[down] = rows.block;
      index[slice.axis] = level.blockOf(slice.axis, voxel[slice.axis]);
      const int64_t block = level.layout.idOf(index);
      // The background is there already.
      if (!level.mayDiffer(block)) continue;
      const BlockName key{.time = slice.time, .level = level.number, .block = block};
      const VolumeBlockPtr voxels = session.readBlocks(std::span(&key, 1)).front();
      for (int y = rows.begin; y < rows.end; ++y)
        for (int x = run.begin; x < run.end; ++x) {
          voxel[across] = level.voxelAt(across, x * result.every);
          voxel[down] = level.voxelAt(down, y * result.every);
          result.values[static_cast<size_t>(y) * static_cast<size_t>(result.width) +
                        static_cast<size_t>(x)] =
              static_cast<float>(storedValue(map, deviceValue(*voxels, voxel)));
        }
    }
  return result;
}

}  // namespace sluice
