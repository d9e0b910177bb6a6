// Level 1 without a disk: voxels in memory that somebody else owns, or that a function gives.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "src/base/sources/volume_source.h"

namespace sluice {

// Copies the voxels of a box of a time step to `out`, x fastest, packed. Several threads call.
using FillRegion = std::function<void(int64_t time, const Box3& box, std::span<std::byte> out)>;

// `layout` with its place: world steps from a voxel to its neighbour along x, y and z, and the
// position of the first. Throws Error, which starts with the layout's name: dims, time steps or a
// place that none can be.
VolumeLayout lentLayout(VolumeLayout layout, const std::array<Vec3d, 3>& steps, Vec3d origin);

// Throws Error: `fill` is empty.
std::unique_ptr<VolumeSource> lentSource(FillRegion fill, VolumeLayout layout);

// A volume of which only the voxels of `there` are at hand. `fill` gives boxes of them, with
// positions counted from there.lo. All other voxels have the value of the voxel at `outside`, which
// is one of these. Requires: `there` is not empty and within the volume. Throws as lentSource()
// does.
std::unique_ptr<VolumeSource> lentBoxSource(FillRegion fill, VolumeLayout layout, const Box3& there,
                                            Vec3i outside);

// Copies boxes of an array whose voxel (0, 0, 0) of step 0 is at `first`. `strides`: bytes between
// neighbours along x, y, z and time. Throws Error: there is no array.
FillRegion fillFrom(const void* first, const VolumeLayout& layout,
                    const std::array<int64_t, 4>& strides);
// The strides of a packed array, x fastest.
std::array<int64_t, 4> packedStrides(const VolumeLayout& layout);

}  // namespace sluice
