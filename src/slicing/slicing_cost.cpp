#include "src/slicing/slicing_cost.h"

#include <algorithm>
#include <random>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/slicing/incremental_slicer.h"
#include "src/slicing/plain_slicer.h"

namespace sluice {
namespace {

constexpr int kBoxes = 2000;
constexpr double kLeastSide = 4, kMostSide = 32, kBlock = 64, kStep = 0.5;

using Slice = void (*)(const SlicePlanes&, std::span<const SlicedBox>, SliceList&);

// Nanoseconds a slice.
double measure(Slice slice, const SlicePlanes& planes, std::span<const SlicedBox> boxes,
               SliceList& list) {
  list.vertices.clear();
  list.polygons.clear();
  Stopwatch watch;
  slice(planes, boxes, list);
  return 1e9 * watch.lap() / static_cast<double>(std::max<size_t>(1, list.polygons.size()));
}

double median(std::vector<double>& values) {
  // The median, not the mean: on a shared machine a view that is interrupted costs many times more.
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

SlicingCost slicingCost(int views, uint64_t seed) {
  SLUICE_CHECK_LE(1, views);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<SlicedBox> boxes(kBoxes);
  for (SlicedBox& box : boxes)
    for (int a = 0; a < 3; ++a) {
      const double side = kLeastSide + (kMostSide - kLeastSide) * unit(random);
      box.lo[a] = (kBlock - side) * unit(random);
      box.hi[a] = box.lo[a] + side;
      box.texture_scale[a] = 1 / kBlock;
    }
  SliceList list;
  SlicingCost cost;
  std::vector<double> plain, incremental;
  // The first view is not counted: it makes the arrays grow.
  for (int view = -1; view < views; ++view) {
    SlicePlanes planes;
    // A vector near the origin would leave its direction to the grid of random numbers.
    while (length(planes.normal) < 0.1)
      for (int a = 0; a < 3; ++a) planes.normal[a] = 2 * unit(random) - 1;
    planes.normal = normalized(planes.normal);
    planes.step = kStep;
    planes.first = -2 * kBlock;
    // Both slicers cut the same boxes with the same planes, one directly after the other, so that
    // what else the machine does falls on both.
    const double from_scratch = measure(slicePlainly, planes, boxes, list);
    const double step_by_step = measure(sliceIncrementally, planes, boxes, list);
    if (view < 0) continue;
    plain.push_back(from_scratch);
    incremental.push_back(step_by_step);
    cost.slices += static_cast<int64_t>(list.polygons.size()) / views;
  }
  cost.plain_ns = median(plain);
  cost.incremental_ns = median(incremental);
  return cost;
}

}  // namespace sluice
