// The plain slicer: each slice is cut with all twelve edges of the box from scratch and the points
// are sorted around their middle, as is conventional (Li 2003, section 3.3). It is the oracle of
// the incremental slicer and the baseline of its measurements. Pure function, any thread.
#pragma once

#include <span>

#include "src/slicing/slices.h"

namespace sluice {

// Appends the polygons of all slices that cut each box.
void slicePlainly(const SlicePlanes& planes, std::span<const SlicedBox> boxes, SliceList& result);

}  // namespace sluice
