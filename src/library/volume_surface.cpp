#include "src/library/volume_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "io/zarr/levels/level_shape.h"
#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "src/base/values/corners.h"
#include "src/index/stale_check.h"

namespace sluice {
namespace {

// The level as a volume of its own.
struct Level {
  VolumeSource& source;
  LevelPlacement placement;
  LevelValues values = LevelValues::kUnknown;
};

Level levelOf(const IndexedVolume& volume, int64_t number) {
  if (number == 0) return {*volume.source, {}};
  const std::span<const CoarserLevel> levels = coarserLevels(*volume.source);
  if (number > static_cast<int64_t>(levels.size()))
    failRequest(
        "{}: has no level {}, only {}; --levels always makes coarser ones of volumes with more "
        "than "
        "{} voxels along an axis, and so does sluice pack",
        volume.name, number,
        levels.empty() ? std::string("level 0") : fmt::format("0 to {}", levels.size()),
        kCoarsestSide);
  const CoarserLevel& level = levels[static_cast<size_t>(number - 1)];
  return {*level.source, level.placement, level.values};
}

// The cells of a level whose corners lie within the crop.
Box3 regionCells(const SurfaceOptions& options, const Level& level, Vec3i finest_dims,
                 const std::string& name) {
  const Vec3i dims = level.source.layout().dims;
  const Box3 all = boxOf(dims - Vec3i{1, 1, 1});
  if (!options.crop) return all;
  const Vec3d lo = level.placement.levelFromFinest(toDouble(options.crop->lo));
  const Vec3d hi = level.placement.levelFromFinest(
      toDouble(min(options.crop->hi, finest_dims) - Vec3i{1, 1, 1}));
  Box3 cells;
  constexpr double kRounding = 1e-6;
  for (int a = 0; a < 3; ++a) {
    // Only cells with all corners inside, so rounding goes inward; kRounding forgives positions
    // that scales shifted.
    cells.lo[a] = static_cast<int64_t>(std::ceil(lo[a] - kRounding));
    cells.hi[a] = static_cast<int64_t>(std::floor(hi[a] + kRounding));
  }
  cells = intersect(cells, all);
  if (cells.empty())
    failRequest("{}: the crop has no cell between voxels of {} x {} x {}; give a larger one", name,
                dims.x, dims.y, dims.z);
  return cells;
}

BlockStates statesOf(const IndexedVolume& volume, const SurfaceOptions& options, const Level& level,
                     const InsideSet& inside, const SurfaceRegion& region) {
  const SliceRanges& ranges = volume.index->ranges;
  const Box3* const closed_at = region.is_closed ? &region.cells : nullptr;
  if (options.level == 0) return blockStates(ranges, inside, closed_at);
  const BlockLayout blocks =
      blockLayout(level.source.layout().dims, ranges.layout.size, 1, volume.name.c_str());
  return blockStates(ranges, inside, closed_at, blocks, level.placement, level.values);
}

// A warning if positions as floats are too coarse for the voxels' size.
void warnOfFloats(const IndexedVolume& volume, const SurfacePlace& place, const Box3& cells,
                  std::vector<std::string>& warnings) {
  double farthest = 0, finest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d world = place.worldFromVoxel(toDouble(cornerOf(cells, corner)));
    for (int a = 0; a < 3; ++a) farthest = std::max(farthest, std::abs(world[a]));
  }
  for (const Vec3d& step : place.step) finest = std::min(finest, length(step));
  const double apart = farthest * double{std::numeric_limits<float>::epsilon()};
  constexpr double kShare = 0.01;
  if (apart > kShare * finest)
    warnings.push_back(
        fmt::format("{}: lies so far from the origin of the world that positions in the mesh are "
                    "multiples of {:.2g}, with voxels {:.2g} apart",
                    volume.name, apart, finest));
}

}  // namespace

IndexNeeds surfaceNeeds(const SurfaceOptions& options) {
  IndexNeeds needs = kUsualNeeds;
  if (options.level > 0) {
    needs.levels = LevelNeeds::kAll;
    needs.may_stand_in = true;  // the finest level only tells which blocks need not be read
  }
  return needs;
}

VolumeSurface makeSurface(const IndexedVolume& volume, const SurfaceOptions& options,
                          MeshFile& file, const IndexPass& pass) {
  const Level level = levelOf(volume, options.level);
  const VolumeLayout& finest = volume.source->layout();
  const InsideSet inside = insideSet(volume.map, options.threshold);
  const SurfaceRegion region{regionCells(options, level, finest.dims, volume.name),
                             options.is_closed};
  VolumeSurface made;
  made.dims = level.source.layout().dims;
  const SurfacePlace place = surfacePlace(finest, level.placement);
  warnOfFloats(volume, place, region.cells, made.warnings);
  BlockStates states = statesOf(volume, options, level, inside, region);
  const uint64_t held = volume.rangesBytes() + states.blocks.size() * sizeof(BlockStates::Block);
  const uint64_t left = pass.memory_bytes - std::min(pass.memory_bytes, held);
  // Half of the memory holds decoded chunks of compressed files. A source without such chunks
  // leaves all of it to the surface.
  const uint64_t decoded = left / 2;
  volume.source->holdAtMost(decoded);
  const bool is_decoded = volume.source->heldBytesAThread() > 0;
  SurfaceRequest request{.source = level.source,
                         .time = volume.time,
                         .inside = inside,
                         .place = place,
                         .region = region,
                         .states = std::move(states),
                         .check = {},
                         .memory_bytes = is_decoded ? left - decoded : left,
                         .stop = pass.stop};
  // Voxels are checked against the min-max arrays that decided which blocks are read, so a file
  // that changed since is found.
  if (options.level == 0)
    request.check = [&volume, &finest](int64_t block, double lo, double hi) {
      const SliceRanges& ranges = volume.index->ranges;
      expectSameValues({.time = volume.time, .block = block}, {lo, hi},
                       expectedValues(ranges, block), {finest.name, ranges.map, ranges.index_file});
    };
  const uint64_t least = leastSurfaceBytes(request);
  // As much again holds decoded chunks.
  const uint64_t needed = is_decoded ? 2 * least - 1 : least;
  if (least > request.memory_bytes)
    failMemory(
        "{}: --memory {} is too small for a surface: the index takes {}, voxels and triangles {}; "
        "give --memory {}",
        volume.name, formatBytes(pass.memory_bytes), formatBytes(held), formatBytes(needed),
        held + needed);
  made.report = makeSurface(request, file, pass.pool, pass.progress);
  if (made.report.triangles == 0) {
    const ValueRange values = volume.finiteRange();
    const std::string found = volume.index->ranges.mayHoldNumbers()
                                  ? fmt::format("values are from {} to {}", values.lo, values.hi)
                                  : "no value is a finite number";
    made.warnings.push_back(
        fmt::format("{}: no surface at {}, the mesh is empty: {}{}", volume.name, options.threshold,
                    found, options.crop ? ", and the surface may lie outside the crop" : ""));
  }
  return made;
}

}  // namespace sluice
