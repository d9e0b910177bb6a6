#include "src/render/frame/frame_occlusion.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

// A share of a cell: rounding may cut this much off a box that is clipped.
constexpr double kMarginCells = 1e-6;

MapProjection projectionOf(const FrameSetup& setup, const EyePosition& eye, const Box3& hull) {
  const RealBox volume{toDouble(hull.lo), toDouble(hull.hi)};
  if (eye.parallel) return parallelMap(volume, eye.index, OpacityMap::kDefaultSide);
  const RayGrid& rays = setup.rays;
  const Vec3d direction = rays.step0 + rays.step_dx * (0.5 * setup.size.width) +
                          rays.step_dy * (0.5 * setup.size.height);
  return perspectiveMap(volume, eye.index, direction, OpacityMap::kDefaultSide);
}

}  // namespace

FrameOcclusion::FrameOcclusion(Occlusion how, const FrameSetup& setup, const EyePosition& eye,
                               const Work& work)
    : how_(how),
      threshold_(static_cast<float>(work.opaque)),
      clip_from_index_(setup.clip_from_index),
      projection_(projectionOf(setup, eye, work.hull)),
      schedule_(work.cells, work.updates) {
  SLUICE_CHECK(how != Occlusion::kOff);
  report_.updates_wanted = work.updates;
}

bool FrameOcclusion::hides(const Box3& cells) const {
  return how_ != Occlusion::kMap && map_.isOpaque(project(projection_, asReal(cells)), threshold_);
}

std::optional<Box3> FrameOcclusion::visible(const Box3& cells) {
  report_.cells += cells.count();
  last_drawn_ = cells.count();
  // Nothing hides anything before the first update.
  if (!map_.valid()) return cells;
  const Box3 shown = shownPart(cells);
  hidden_cells_ += cells.count() - shown.count();
  if (how_ == Occlusion::kMap) return cells;
  if (shown.empty()) {
    report_.cells_culled += cells.count();
    last_drawn_ = 0;
    return std::nullopt;
  }
  if (how_ == Occlusion::kCull) return cells;
  last_drawn_ = shown.count();
  report_.cells_clipped += cells.count() - shown.count();
  return shown;
}

// Empty if nothing shows.
Box3 FrameOcclusion::shownPart(const Box3& cells) const {
  const RealBox box = asReal(cells);
  const std::optional<RealBox> real =
      clip(projection_, box, map_.visiblePart(project(projection_, box), threshold_));
  Box3 shown;
  for (int a = 0; real && a < 3; ++a) {
    // Outwards to whole cells, since boxes consist of cells: a clipped box draws no less than what
    // shows.
    shown.lo[a] =
        std::max(cells.lo[a], static_cast<int64_t>(std::floor(real->lo[a] - kMarginCells)));
    shown.hi[a] =
        std::min(cells.hi[a], static_cast<int64_t>(std::ceil(real->hi[a] + kMarginCells)));
  }
  return shown;
}

void FrameOcclusion::leaveOut(int64_t cells) {
  report_.cells += cells;
  report_.cells_culled += cells;
  hidden_cells_ += cells;
}

MapGrid FrameOcclusion::grid() const {
  MapGrid grid;
  grid.side = map_.side();
  const MapProjection& p = projection_;
  // A place (i, j) on the map lies at u0 + i / u_scale and v0 + j / v_scale on the map's plane,
  // which a row takes to clip space.
  for (size_t i = 0; i < 3; ++i) {
    const auto& row = clip_from_index_[i];
    const auto at = [&row](int axis) { return row[static_cast<size_t>(axis)]; };
    grid.clip_from_map[i] = {at(p.u) / p.u_scale, at(p.v) / p.v_scale,
                             at(p.axis) * p.plane + at(p.u) * p.u0 + at(p.v) * p.v0 + row[3]};
  }
  // w is 1 somewhere on the map, whatever the world's units.
  const auto& w = grid.clip_from_map[2];
  const double scale = std::abs(w[0]) * grid.side + std::abs(w[1]) * grid.side + std::abs(w[2]);
  for (auto& row : grid.clip_from_map)
    for (double& number : row) number /= scale;
  return grid;
}

OcclusionReport FrameOcclusion::report() const {
  OcclusionReport report = report_;
  report.updates = schedule_.updates();
  return report;
}

}  // namespace sluice
