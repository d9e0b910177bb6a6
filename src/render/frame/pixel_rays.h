// Several rays through each pixel, for parts that are thinner than the distance between the rays of
// neighbouring pixels: one ray alone may pass beside them. The picture of one ray a pixel is drawn
// once for each, with the rays shifted inside the pixels, and each pixel shows the most of them
// (KeptRay). A mean of the rays would hide again what is much smaller than a pixel. Pure functions.
#pragma once

#include <array>
#include <optional>

#include "src/base/values/picture.h"
#include "src/device/frame_values.h"
#include "src/render/blocks/time_step.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// The most rays of a picture.
inline constexpr double kMostRays = 1 << 26;

// A pixel shows the greatest number of any ray in each of red, green, blue and opacity, and the
// nearest depth (each channel). No ray is chosen, since rounding would choose: most rays of a
// surface are opaque but for rounding, which differs between devices and between block sizes, and
// they differ in colour. Numbers of pixels differ by no more than those of rays. Colours of labels
// and of values may not mix. Their pixels show the ray with the greatest sum of 4 times the opacity
// and of the colours (brightest), or of minus the colours (darkest).
enum class KeptRay { kEachChannel, kBrightest, kDarkest };
// The rays of a picture: along each side of a pixel, and which of them it shows.
struct PixelRays {
  int a_side = 1;
  KeptRay kept = KeptRay::kBrightest;
};
// Returns what a pixel keeps in this mode. Modes with colours keep each channel, or the brightest
// ray of labels. An extreme keeps the ray whose value wins, if the look's colours become ever
// brighter, or ever darker, with the values. nullopt: colours do not tell which ray it is, or the
// mode looks at all of them.
std::optional<KeptRay> keptRay(const LookUp& look_up, Mode mode);

// The rays along each side of a pixel: 1, or, for a cut that keeps thin parts, as many as leave a
// third of a voxel between them wherever the picture shows voxels that are smaller than pixels: of
// the finest level, and of all levels if these hold extremes. Interpolation reaches a voxel far to
// each side and falls off towards there.
int raysASide(const TimeStep& step, const VisibleBlocks& visible, const View& view,
              const FrameOptions& options);

// The distance of ray (x, y) of a pixel, with `side` of them along each side, from the pixel's
// middle: in pixels to the right and up. Requires: x and y are below `side`.
std::array<double, 2> shiftOfRay(int x, int y, int side);

// Makes each pixel of `kept` the one that shows what is kept of its own rays and of the ray of
// `more`. Requires: pictures of one size, both with depth or neither.
void keepMost(Picture& kept, const Picture& more, KeptRay ray);

}  // namespace sluice
