// The values that a device needs for a frame, from the view, the volume's layout and the options.
// Pure functions.
#pragma once

#include "src/classify/transfer/opacity_table.h"
#include "src/device/frame_values.h"
#include "src/render/blocks/look.h"
#include "src/render/camera/frame_options.h"
#include "src/texture/texture_plan.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// The mode for device values. If the scale is negative, the greatest value is the least of these.
constexpr Mode deviceMode(Mode mode, double value_scale) {
  return value_scale < 0 ? traitsOf(mode).for_negated : mode;
}

FrameSetup frameSetup(const View& view, const VolumeLayout& layout, const OpacityTable& table,
                      const ValueMap& map, const FrameOptions& options);
// The same for a frame of a session that is lit or not, with the counts that its options ask for.
FrameSetup frameSetup(const View& view, const VolumeLayout& layout, const Look& look,
                      const ValueMap& map, const FrameOptions& options, bool lit);

// Shifts the view by so many pixels to the right and up, its rays and its clip space alike: devices
// look for the pixels of a box in clip space, and at the box along the rays.
void shiftView(FrameSetup& setup, std::array<double, 2> pixels);

// The view's part of it alone: rays, clip space, slices and clip planes.
FrameSetup viewSetup(const View& view, const VolumeLayout& layout,
                     const std::vector<WorldPlane>& clip_planes);
// FrameSetup::shown_depths of such a frame: those of FrameOptions::shown_points, as far as they lie
// between the corners that the clip planes leave of cropCells().
std::array<double, 2> shownDepths(const View& view, const VolumeLayout& layout,
                                  const FrameOptions& options);

// Clip planes of the world in index space.
std::vector<ClipPlane> clipPlanes(const std::vector<WorldPlane>& planes,
                                  const VolumeLayout& layout);

// The most voxels between two slices along any axis, of all rays of the view.
double longestStep(const View& view, const VolumeLayout& layout, Vec3d voxel = {1, 1, 1});
// The most for a frame that integrates: the values half as far from a sample lie within the ghost
// layer around its block.
inline constexpr double kMostIntegratedStep = 2;
// Whether a view's slices lie close enough for it.
bool stepsIntegrate(const View& view, const VolumeLayout& layout);

// The eye's position for ordering blocks front to back.
EyePosition eyePosition(const View& view, const VolumeLayout& layout);

}  // namespace sluice
