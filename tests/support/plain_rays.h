// The rays of the plain device and their samples, in plain loops, as FrameSetup has them.
#pragma once

#include <array>
#include <functional>

#include "src/device/device.h"

namespace sluice {

struct PlainRay {
  Vec3d origin, step;
  double length = 1;  // length between two slices, in units of FrameSetup::slice_length
  double jitter = 0;  // slices by which the ray begins farther away

  Vec3d at(double slice) const { return origin + step * (slice + 0.5); }
};

// The ray of a pixel, y upwards.
PlainRay plainRayOf(const FrameSetup& setup, int x, int y);

// Slices [from, to) of the ray inside the cells and the clip planes.
std::array<int64_t, 2> slicesIn(const PlainRay& ray, const Box3& cells, const FrameSetup& setup);

// Visits the samples of the ray inside the box: visit(position, slice) until it returns false.
void eachSample(const PlainRay& ray, const BoxDraw& box, const FrameSetup& setup,
                const std::function<bool(Vec3d position, double slice)>& visit);

// Visits each pixel that may see the cells.
void eachPixelOf(const Box3& cells, const FrameSetup& setup,
                 const std::function<void(int x, int y)>& visit);

// A number of pixels as a whole one, whatever its size.
int clampedInt(double v);

}  // namespace sluice
