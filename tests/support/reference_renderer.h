// The independent reference: the picture as the contracts of src/render/camera/camera.h,
// src/device/shading/lighting.h and src/classify/transfer/transfer_function.h define it, in plain
// double-precision loops over the pixels and the slices of a View. No blocks, no skipping, no
// tables, and nothing of the renderer but those structs.
//
// Maxima and minima are taken where a ray enters what is shown, where it leaves it, and between the
// two where it meets the voxel planes of the axis that it runs along most (in voxels; the first of
// those alike to 1e-4), or at ceil(1 / step) places a voxel there, the step in units of the finest
// spacing. Faces are shown too, to a thousandth of a voxel. Everything else is taken at the slices,
// where a sample with labels has the value of the greatest weight.
//
// A composite picture of a transfer function with surfaces looks at the way from half a slice
// before each sample to half a slice behind it. A surface is met if the values at both ends lie on
// its two sides (those that equal its value on the upper side), where the value has reached it.
// The sample's colour lasts over the whole way, in parts before, between and behind the surfaces.
//
// A slice's sample counts if 0 <= p[a] < dims[a] - 1 on every axis (p: its position in voxels),
// inside the crop box and kept by every clip plane. Infinities count as +-1e30; a sample with any
// part of a NaN shows nothing, and an axis along which a gradient would meet one adds nothing to it
// (src/volume/voxels/device_voxel.h). Reads the whole time step into memory.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/device/shading/lighting.h"
#include "src/render/camera/camera.h"
#include "tests/support/float_picture.h"

namespace sluice {

enum class ReferenceMode {
  kComposite,
  // Over the values of the samples whose opacity is above 0; the colour of that one value, opaque,
  // or transparent if there is no such sample. Unlit; depth is 0.
  kMaximum,
  kMinimum,
  kAverage,
  // Each value counts with its place between the ends of the colours, 0 to 1, times
  // exp(-attenuation * s), where s is the integral of these places over the way in front of it in
  // voxel lengths of the finest spacing. The colour of the greatest, opaque.
  kAttenuatedMaximum,
  // The greatest place between the ends of the colours, in steps of 1 / 4094 beginning at
  // -0.618 / 4094, and of places in one step the nearest. Its colour is that of the transfer
  // function between its last colour, at the depth of the nearest corner of the crop box (in front
  // of a perspective eye), and its first, at that of the farthest corner; times the step's place.
  kMaximumByDepth,
};

// A sample is kept if dot(normal, world position) <= offset.
struct ReferenceClipPlane {
  Vec3d normal;
  double offset = 0;
};

// The rounding of a renderer of single precision; FloatPicture::doubt is the change that it may
// cause in each pixel. With zeros nothing is in doubt.
struct Rounding {
  // A step of the transfer function (two points at one value, or almost), of its gradient rows too,
  // is met within this many value units of it.
  double step_value = 0;
  // Modes other than composite: an end of the visible values is doubtful too.
  double end_value = 0;
  // A face of the volume, of the crop box or a clip plane within this many voxels.
  double face_vox = 0;
  // Labels: a weight among the eight voxels.
  double label_weight = 0;
  // kMaximumByDepth: a place may lie so many steps off.
  double place_steps = 0;
};

struct ReferenceScene {
  TransferFunction transfer;
  ReferenceMode mode = ReferenceMode::kComposite;
  int64_t time = 0;
  std::optional<Box3> crop;  // voxels: a sample counts if lo <= p < hi - 1
  std::vector<ReferenceClipPlane> clip_planes;
  std::optional<Lighting> lighting;  // unlit if absent
  ValueRange value_range;            // range of the volume, for Lighting::flat_share
  // Composite, not of labels: a sample shows all values from half a slice before it to half a slice
  // behind it, which change linearly between these two places. An opacity counts as its extinction,
  // -log2(1 - opacity), at most 16, and a colour in proportion to the extinction. Factors of
  // gradients are for the mean of the two values. If one of them is no number, the other counts.
  // Requires: no step in the transfer function.
  bool integrates = false;
  double attenuation = 0;  // of kAttenuatedMaximum
  // Composite: a sample's colour is darkened by this share at the farthest depth, by none at the
  // nearest. These depths, and those of kMaximumByDepth, belong to the points given here, or, if
  // there are none, to the corners of the crop box.
  double depth_cueing = 0;
  std::vector<Vec3d> shown_points;  // world space, inside the crop box
  // Composite: the slices of the ray of pixel (i, j) lie farther by jitter times this function.
  double jitter = 0;
  std::function<double(int i, int j)> jitterOf;
  double opacity_threshold = 1;  // a ray ends once its opacity has reached this
  Rounding rounding;
};

// Composites front to back: opacity a of one voxel length, times the factor of the gradient's
// magnitude where the transfer function has gradients, of the finest spacing becomes
// 1 - (1 - a)^(L / finest), L being the ray's way between two slices. Depth is the opacity-weighted
// mean depth of the samples. Runs on all cores.
FloatPicture renderReference(VolumeSource& source, const View& view, const ReferenceScene& scene);

}  // namespace sluice
