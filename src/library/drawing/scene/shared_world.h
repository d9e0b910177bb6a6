// A volume drawn over another one: both lie in one world, each on a grid of its own.
//
// Positions of the first volume's world become those of the other one's by the meaning of their
// axes (NIfTI's point to the right, front and top, DICOM's to the left, back and top) and by their
// units of length, as far as the files tell both. A frame's options are the first volume's; the
// other volume is drawn with the options that show the same part of the world from the same eye.
// Pure functions.
#pragma once

#include <optional>

#include "src/base/sources/volume_source.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// Whether the same options show both alike, as those of the channels of a file: also the meaning of
// the axes, which views follow, and the unit are the same.
bool isSamePlace(const VolumeLayout& a, const VolumeLayout& b);
// Whether both have the same voxels at the same positions, whichever world these are given in, but
// for a rounding of a thousandth of a voxel.
bool isSameGrid(const VolumeLayout& a, const VolumeLayout& b);

// A length in world units of `to` that is one world unit of `from`; 1 if a unit is not known.
double worldScale(const VolumeLayout& from, const VolumeLayout& to);
// A position, or a direction without a unit, of one world in the other one.
Vec3d positionOn(const VolumeLayout& to, const VolumeLayout& from, Vec3d world);
Vec3d directionOn(const VolumeLayout& to, const VolumeLayout& from, Vec3d world);

// The camera that looks at `to` as `camera` looks at `from`. Throws as resolve() does.
Camera cameraOn(const VolumeLayout& to, const VolumeLayout& from, const Camera& camera,
                PictureSize size);
// The voxels of `to` around the cells that a crop of `from` shows, empty if there are none.
std::optional<Box3> cropOn(const VolumeLayout& to, const VolumeLayout& from,
                           const std::optional<Box3>& crop);
// The options of a frame of `from` for `to`, the same ones if the places are. Slices have the same
// distance in the world, or a quarter of a voxel of `to` if that is more, the sides of a crop
// become clip planes, colours by depth span the depths of `from`, and a level of resolution that
// was asked for is that of `from` alone. Throws as resolve() does.
FrameOptions frameOn(const VolumeLayout& to, const VolumeLayout& from, const FrameOptions& frame);
// The step of `from`, in voxels, that is so many voxels of `to`.
double stepOn(const VolumeLayout& from, const VolumeLayout& to, double step_vox);

}  // namespace sluice
