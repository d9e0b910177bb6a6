// FrameOptions: the options that may change from one frame to the next, including the camera. Plain
// data.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/device/frame_values.h"
#include "src/device/shading/lighting.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/cut_options.h"
#include "src/render/frame/frame_occlusion.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// Keeps world positions p with dot(normal, p) <= offset.
struct WorldPlane {
  Vec3d normal;
  double offset = 0;
};

// The boxes that are drawn of a texture block: its object box, or the visible ones of its growing
// boxes (Li 2003), which hold fewer empty cells. The picture is the same.
enum class Partition { kBlocks, kBoxes };
inline constexpr std::array kPartitions = {Partition::kBlocks, Partition::kBoxes};
constexpr std::string_view name(Partition partition) {
  return partition == Partition::kBlocks ? "blocks" : "boxes";
}

// A device leaves these samples out inside the boxes that it draws. The picture is the same.
enum class Skipping {
  // Nothing: it reads, lights and blends every sample, as renderers without empty space skipping do
  // (Li's Basic): the baseline for measuring skipping.
  kNone,
  // The light and the blending of samples that show nothing: for benches that measure the papers'
  // ways of skipping without leaps.
  kShading,
  // Whole stretches of rays, too, if it can: rays leap over cells that show nothing, and end where
  // nothing behind could be seen.
  kLeaps,
};

// Whether a picture that is too large for its share of the memory may be drawn in strips.
enum class Strips {
  kMayBe,
  kUnlessRefined,  // not if it is a row of pictures that get better
  kNever,          // whoever draws it looks at the whole picture
};

// Opaque enough to leave out everything behind (Li 2003, section 4.1).
inline constexpr double kDefaultOpaque = 0.95;

struct FrameOptions {
  Camera camera;
  PictureSize size;
  Strips strips = Strips::kMayBe;
  double step_vox = 1;  // between slices, in units of the finest spacing
  Mode mode = Mode::kComposite;
  // How far the rays lie beside the middles of the pixels, in pixels to the right and up.
  std::array<double, 2> ray_shift{0, 0};
  bool with_depth = false;
  // From this opacity on a pixel counts as opaque, see rayThreshold() and hidingThreshold(). 1: the
  // picture does not change. Unset: 1; kDefaultOpaque for occlusion, and for a chooser that culls
  // blocks by opacity functions (src/render/blocks/culled_blocks.h).
  std::optional<double> opacity_threshold;
  Occlusion occlusion = Occlusion::kOff;  // composite only
  bool shades = true;                     // by sessions opened lit; they may draw a frame without
  Lighting lighting;                      // Applies if the frame is lit
  double depth_cueing = 0, jitter = 0;    // see FrameSetup
  bool is_one_of_several = false;         // see FrameSetup
  // World positions whose hull holds what the transfer function shows, for pictures whose colours
  // depend on depth. Null or none: the corners that the clip planes leave of cropCells().
  std::shared_ptr<const std::vector<Vec3d>> shown_points = {};
  // The depths that such colours span, in place of those that follow from the points.
  std::optional<std::array<double, 2>> shown_depths = {};
  std::optional<CutOptions> cut;  // unset: the finest level alone is drawn
  // Voxels; the part between the outer voxel planes is shown. One plane along an axis has no part
  // between: it is shown one voxel thick (planesOf()).
  std::optional<Box3> crop;
  std::vector<WorldPlane> clip_planes;
  Algorithm algorithm = Algorithm::kMerged;
  MergeOrder merge_order = MergeOrder::kPaper;
  Partition partition = Partition::kBlocks;  // kBoxes only if the session has boxes
  // How long a frame may wait for missing data, including its drawing as far as the last frame
  // predicts it. The data still missing then is left out; later frames have it. A frame of a cut
  // leaves nothing out: it shows parts coarser whose data would not come in time (read_limit.h).
  // Unset: waits for all data.
  std::optional<double> time_limit_s;
  // The distance between slices grows with the voxels if the time limit makes a cut coarser.
  bool step_follows_cut = false;
  bool keep_phases = false;  // fills Frame::phases; with occlusion
  Skipping skipping = Skipping::kLeaps;
  // Ends the frame, see Session::frame().
  StopToken stop = {};
  // Called with the number of clusters drawn and of all: before the first, and after each. Called
  // by the drawing thread.
  ProgressWatch watch = {};
  // Samples show all values between them, if the frame can: Planner::integrates().
  bool integrates = false;
  double step_factor = 1;      // of a step that is chosen and integrated
  bool count_samples = false;  // fills FrameReport::samples_*; costs a pass without texture reads
  // With it, samples_taken leaves out leapt samples, even if no ray ends early.
  bool counts_leaps = false;
};

// The view of a frame of this volume. Throws as resolve() of a camera does.
inline View resolve(const FrameOptions& options, const VolumeLayout& volume) {
  return resolve(options.camera, volume, options.size, options.step_vox);
}

// The opacity from which on boxes behind are hidden, rays end and pixels take no more samples: the
// paper's ESS+M and ESS+C take all samples of the boxes that they draw.
inline double hidingThreshold(const FrameOptions& options) {
  return options.opacity_threshold.value_or(kDefaultOpaque);
}
inline double rayThreshold(const FrameOptions& options) {
  switch (options.occlusion) {
    case Occlusion::kOff:
      return options.opacity_threshold.value_or(1);
    case Occlusion::kClip:
      return hidingThreshold(options);
    case Occlusion::kMap:
    case Occlusion::kCull:
      break;
  }
  return 1;
}

// Whether a picture depends on FrameSetup::shown_depths.
inline bool colorsByDepth(const FrameOptions& options) {
  const ModeTraits& traits = traitsOf(options.mode);
  return traits.codes_depth || (traits.has_colors && options.depth_cueing > 0);
}

// The planes that are the only one along an axis of what a crop has of a volume.
inline VoxelPlanes planesOf(const std::optional<Box3>& crop, Vec3i dims) {
  VoxelPlanes planes;
  if (!crop) return planes;
  const Box3 inside = intersect(*crop, boxOf(dims));
  for (int a = 0; a < 3; ++a)
    if (inside.hi[a] - inside.lo[a] == 1) planes[static_cast<size_t>(a)] = inside.lo[a];
  return planes;
}

// The cells that a crop lets show: those between its outer voxel planes. One plane has those up to
// the next plane, and the last one those from the plane before it; all of each cell shows the
// values of the one plane.
inline Box3 cropCells(const std::optional<Box3>& crop, Vec3i dims) {
  const Box3 all = boxOf(dims - Vec3i{1, 1, 1});
  if (!crop) return all;
  Box3 cells{crop->lo, crop->hi - Vec3i{1, 1, 1}};
  const VoxelPlanes planes = planesOf(crop, dims);
  for (int a = 0; a < 3; ++a) {
    const auto plane = planes[static_cast<size_t>(a)];
    if (!plane) continue;
    cells.lo[a] = std::min(*plane, dims[a] - 2);
    cells.hi[a] = cells.lo[a] + 1;
  }
  return intersect(cells, all);
}
inline Box3 cropCells(const FrameOptions& options, Vec3i dims) {
  return cropCells(options.crop, dims);
}

// The part of a crop that has these of its cells. A plane that is the only one stays the only one.
inline Box3 cropTo(const Box3& cells, const std::optional<Box3>& crop, Vec3i dims) {
  Box3 part{cells.lo, cells.hi + Vec3i{1, 1, 1}};
  const VoxelPlanes planes = planesOf(crop, dims);
  for (int a = 0; a < 3; ++a)
    if (const auto plane = planes[static_cast<size_t>(a)]) {
      part.lo[a] = *plane;
      part.hi[a] = *plane + 1;
    }
  return part;
}

}  // namespace sluice
