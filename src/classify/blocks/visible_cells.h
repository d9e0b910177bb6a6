// visibleCells: which cells of a time step can show anything, for fitting a view to them.
//
// The answer follows from the values and the transfer function alone. It is the same for any size
// of block, lit or not, any type that holds the values, and an index that was read or just built:
// bricks come from a grid of the volume (src/volume/ranges/brick_ranges.h), and plane ranges over
// the whole volume cut their box to whole cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/classify/transfer/transfer_function.h"
#include "src/volume/ranges/brick_ranges.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// Boxes of cells whose convex hull holds every cell of `crop` that can show anything, larger than
// the hull of those by less than a brick in oblique directions and by nothing along the axes
// without a crop. The factors of gradients do not count: they only take away. Empty: nothing shows.
// `ranges` and `bricks` belong to one time step.
std::vector<Box3> visibleCells(const SliceRanges& ranges, const BrickRanges& bricks,
                               const TransferFunction& transfer, const Box3& crop);

// The same for bricks that hold more values than `ranges`, which give their type and background
// alone: larger than the hull by less than a brick along the axes, too, unless visiblePlanes() cuts
// it.
std::vector<Box3> visibleBricks(const SliceRanges& ranges, const BrickRanges& bricks,
                                const TransferFunction& transfer, const Box3& crop);

// The range of each voxel plane of a whole volume along each axis.
struct PlaneRanges {
  std::array<std::vector<std::byte>, 3> along;  // PlaneRange<T>

  uint64_t bytes() const { return along[0].size() + along[1].size() + along[2].size(); }
  template <class T>
  std::span<const PlaneRange<T>> rangesAs(int axis) const {
    const std::vector<std::byte>& bytes = along[static_cast<size_t>(axis)];
    return {reinterpret_cast<const PlaneRange<T>*>(bytes.data()),
            bytes.size() / sizeof(PlaneRange<T>)};
  }
};

// The voxels from the first to the last plane along each axis that can show anything, by itself or
// between it and the next one. Empty: nothing shows.
Box3 visiblePlanes(const PlaneRanges& planes, const ValueMap& map,
                   const TransferFunction& transfer);

// Whether any value of lo..hi has an opacity above 0, whatever the gradient, or is a surface's.
bool anyOpacity(const TransferFunction& transfer, double lo, double hi);

}  // namespace sluice
