#include "src/library/view_fit.h"

#include <algorithm>

#include "src/classify/blocks/visible_cells.h"

namespace sluice {
namespace {

void addStep(VisibleHull& hull, const IndexedRanges& index, const FitRequest& request) {
  hull.add(visibleCells(index.ranges, index.bricks, request.transfer,
                        cropCells(request.frame, index.ranges.layout.dims)));
}

}  // namespace

Fit fitOf(const std::vector<Camera>& cameras, FitChoice choice) {
  const bool looks_at = std::all_of(cameras.begin(), cameras.end(), [](const Camera& camera) {
    return camera.look_at.has_value();
  });
  if (looks_at) return Fit::kVolume;
  const bool plain = cameras.front().view == ViewName::kPlain;
  return choice.value_or(plain ? Fit::kVolume : Fit::kVisible);
}

std::vector<Vec3d> visiblePoints(const FitRequest& request, const IndexPass& pass) {
  const VolumeLayout& layout = request.volume.source->layout();
  VisibleHull hull(layout);
  for (int64_t time = 0; time < layout.time_steps; ++time) {
    if (request.this_step && time != request.step.time) continue;
    if (time == request.volume.time)
      addStep(hull, *request.volume.index, request);
    else
      addStep(hull, rangesOfStep(request.volume, time, pass), request);
  }
  return hull.points();
}

void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const IndexPass& pass) {
  if (fitOf(cameras, choice) == Fit::kVolume) return;
  const auto framing = framingOf(visiblePoints(request, pass), cameras,
                                 request.volume.source->layout().frame, request.frame.size, room);
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
