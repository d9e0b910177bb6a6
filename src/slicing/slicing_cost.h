// The time to cut boxes incrementally and from scratch: the measurement of Li 2003, section 3.3.
// Scenario: 2000 random boxes of 4 to 32 cells a side, as growing boxes are, cut by slices half a
// voxel apart in random views. One thread; arrays are allocated beforehand.
#pragma once

#include <cstdint>

namespace sluice {

struct SlicingCost {
  int64_t slices = 0;                       // polygons of one view, on average
  double plain_ns = 0, incremental_ns = 0;  // a slice, medians over the views
  double ratio() const { return incremental_ns / plain_ns; }
};

// Requires: views >= 1.
SlicingCost slicingCost(int views, uint64_t seed);

}  // namespace sluice
