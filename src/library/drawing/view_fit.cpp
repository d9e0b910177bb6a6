#include "src/library/drawing/view_fit.h"

#include <algorithm>

#include "src/classify/blocks/visible_cells.h"
#include "src/library/drawing/scene/shared_world.h"

namespace sluice {
namespace {

// The cells of the level, of `all`, that show within these finest cells: those beyond the level's
// outermost voxels show the outermost cells. Requires: neither is empty.
Box3 cellsUnder(const LevelLayout& level, const Box3& finest_cells, const Box3& all) {
  const Box3 voxels = level.voxelsUnder(finest_cells);
  const Vec3i one{1, 1, 1};
  const Vec3i lo = max(all.lo, min(voxels.lo, all.hi - one));
  return {lo, max(lo + one, min(voxels.hi - one, all.hi))};
}

// The finest cells that these voxels of the level show, among others. Beyond its outermost voxels
// the level shows their values.
Box3 cellsAround(const LevelLayout& level, const Box3& voxels, const Box3& among) {
  Box3 cells = level.cellsAround(voxels);
  for (int a = 0; a < 3; ++a) {
    if (voxels.lo[a] == 0) cells.lo[a] = among.lo[a];
    if (voxels.hi[a] == level.blocks.dims[a]) cells.hi[a] = among.hi[a];
  }
  return intersect(cells, among);
}

// The cells of a coarse level that can show anything, among the finest ones. Beyond its outermost
// voxels the level shows their values. `reach`: its values with their spreads, which are drawn;
// null: it has none.
std::vector<Box3> cellsOfStandIn(const LevelLayout& level, const IndexedRanges& index,
                                 const ReachRanges* reach, const TransferFunction& transfer,
                                 const Box3& crop) {
  const Box3 all = boxOf(level.blocks.dims - Vec3i{1, 1, 1});
  std::vector<Box3> boxes;
  if (crop.empty()) return boxes;
  Box3 within = crop;
  if (reach != nullptr) {
    const Box3 voxels = visiblePlanes(reach->planes, index.ranges.map, transfer);
    if (voxels.empty()) return boxes;
    within = cellsAround(level, voxels, crop);
  }
  // The crop comes first: of cells in a row, the ends alone are told.
  const Box3 inside = cellsUnder(level, crop, all);
  const std::vector<Box3> visible =
      reach == nullptr ? visibleCells(index.ranges, index.bricks, transfer, inside)
                       : visibleBricks(index.ranges, reach->bricks, transfer, inside);
  for (const Box3& cells : visible) {
    Box3 box = level.cellsOver(cells);
    for (int a = 0; a < 3; ++a) {
      if (cells.lo[a] == all.lo[a]) box.lo[a] = crop.lo[a];
      if (cells.hi[a] == all.hi[a]) box.hi[a] = crop.hi[a];
    }
    box = intersect(box, within);
    if (!box.empty()) boxes.push_back(box);
  }
  return boxes;
}

}  // namespace

std::vector<Box3> shownCells(const IndexedVolume& volume, const StepValues& values,
                             const TransferFunction& transfer, const Box3& crop) {
  const IndexedRanges& index = values.stand_in ? *values.stand_in->index : *values.index;
  if (!values.stand_in || values.stand_in->level == 0)
    return visibleCells(index.ranges, index.bricks, transfer, crop);
  return cellsOfStandIn(volume.pyramid->level(values.stand_in->level), index,
                        values.stand_in->reach.get(), transfer, crop);
}

Fit fitOf(const std::vector<Camera>& cameras, FitChoice choice) {
  // A camera that is told where to look has nothing to be fitted.
  const bool looks_at = std::all_of(cameras.begin(), cameras.end(), [](const Camera& camera) {
    return camera.look_at.has_value();
  });
  if (looks_at) return Fit::kVolume;
  const bool plain = cameras.front().view == ViewName::kPlain;
  return choice.value_or(plain ? Fit::kVolume : Fit::kVisible);
}

std::vector<Vec3d> visiblePoints(const FitRequest& request, const IndexPass& pass) {
  std::vector<Vec3d> points;
  const VolumeLayout& first = request.volumes.front().volume.source->layout();
  for (const FittedVolume& fitted : request.volumes) {
    const VolumeLayout& layout = fitted.volume.source->layout();
    const std::optional<Box3> crop = cropOn(layout, first, request.frame.crop);
    const Box3 cells = cropCells(crop, layout.dims);
    VisibleHull hull(layout);
    // The cells of a single plane have values of the next one, too, which is not shown.
    const bool is_plane = planesOf(crop, layout.dims) != VoxelPlanes();
    if (is_plane) hull.add(std::vector{cells});
    for (int64_t time = 0; time < layout.time_steps && !is_plane; ++time) {
      if (request.this_step && time != fitted.step.time) continue;
      hull.add(shownCells(fitted.volume, valuesOfStep(fitted.volume, time, pass), fitted.transfer,
                          cells));
    }
    for (const Vec3d& point : hull.points()) points.push_back(positionOn(first, layout, point));
  }
  return points;
}

std::shared_ptr<const std::vector<Vec3d>> depthPoints(const FitRequest& request,
                                                      const IndexPass& pass) {
  if (!colorsByDepth(request.frame)) return nullptr;
  return std::make_shared<const std::vector<Vec3d>>(visiblePoints(request, pass));
}

void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const IndexPass& pass) {
  if (fitOf(cameras, choice) == Fit::kVolume) return;
  const auto framing =
      framingOf(visiblePoints(request, pass), cameras,
                request.volumes.front().volume.source->layout().frame, request.frame.size, room);
  for (Camera& camera : cameras) camera.framing = framing;
}

std::vector<Camera> turnOf(const Camera& start, int64_t frames) {
  std::vector<Camera> cameras(static_cast<size_t>(frames), start);
  for (int64_t i = 0; i < frames; ++i)
    cameras[static_cast<size_t>(i)].azimuth_deg =
        start.azimuth_deg + 360 * (static_cast<double>(i) / static_cast<double>(frames));
  return cameras;
}

}  // namespace sluice
