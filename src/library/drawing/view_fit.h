// Fits what is visible into the picture: --fit.
#pragma once

#include <memory>
#include <vector>

#include "src/library/opening/indexed_volume.h"
#include "src/library/opening/step_ranges.h"
#include "src/render/camera/camera_framing.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// An open volume, or a channel of it, and what shows of it.
struct FittedVolume {
  const IndexedVolume& volume;
  TimeStep step;  // the step that is drawn
  const TransferFunction& transfer;
};

struct FitRequest {
  std::vector<FittedVolume> volumes;  // channels of one volume; at least one
  const FrameOptions& frame;          // crop and size
  bool this_step = false;             // ignores what is visible in the other steps
};

// The fit for these cameras; kVolume if they look at a point of their own.
Fit fitOf(const std::vector<Camera>& cameras, FitChoice choice);

// Boxes of cells whose hull holds all that can show anything (visible_cells.h). `values` belong to
// a step of the volume; a stand-in answers in place of a finest level that was not read.
std::vector<Box3> shownCells(const IndexedVolume& volume, const StepValues& values,
                             const TransferFunction& transfer, const Box3& crop);

// The corners of the visible part of each volume (VisibleHull::points()), by cells: the same for
// any size of block. Looks at every time step that counts; reads voxels only of steps that have no
// index yet.
std::vector<Vec3d> visiblePoints(const FitRequest& request, const IndexPass& pass);

// The same for FrameOptions::shown_points; null if the frames do not depend on depth.
std::shared_ptr<const std::vector<Vec3d>> depthPoints(const FitRequest& request,
                                                      const IndexPass& pass);

// Gives all cameras one framing.
void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const IndexPass& pass);

// `frames` cameras once around, from `start` on.
std::vector<Camera> turnOf(const Camera& start, int64_t frames);

}  // namespace sluice
