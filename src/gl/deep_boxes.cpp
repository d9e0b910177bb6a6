#include "src/gl/deep_boxes.h"

#include <algorithm>
#include <utility>

#include "src/device/boxes_together.h"
#include "src/device/drawing_cost.h"

namespace sluice {
namespace {

constexpr double kMostTurns = 60'000;

// The turns of loops that a sample takes, at most: going ahead, light, labels and surfaces, as the
// shaders' texts have them.
int turnsASample(const ShaderVariant& variant) {
  int turns = 4 + variant.gradient_rows;
  if (variant.lit) turns += 16;
  if (variant.fetches) turns += 64;
  if (variant.labels) turns += 2 * 80;
  if (variant.labels && variant.lit) turns += 64 + 20;
  return turns + 24 * variant.surfaces;
}

// Whether rays come to the plane across `axis` at `at` from below.
bool comesFromBelow(const FrameSetup& setup, int axis, int64_t at) {
  const RayGrid& rays = setup.rays;
  if (setup.projection == Projection::kOrtho) return rays.step0[axis] >= 0;
  const double eye = rays.origin0[axis] - rays.step0[axis] * (setup.first_depth / setup.depth_step);
  return eye < static_cast<double>(at);
}

// Appends parts of `cells`, from front to back.
void appendParts(const FrameSetup& setup, const Box3& cells, double most_slices,
                 std::vector<Box3>& parts) {
  const Vec3i size = cells.size();
  // The longest axis is halved, so that parts stay near cubes, whose slices are few.
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  if (size[axis] < 2 || slicesAcross(setup, cells) <= most_slices) {
    parts.push_back(cells);
    return;
  }
  Box3 low = cells, high = cells;
  low.hi[axis] = high.lo[axis] = cells.lo[axis] + size[axis] / 2;
  // Front to back: the half that rays meet first is drawn first.
  if (!comesFromBelow(setup, axis, low.hi[axis])) std::swap(low, high);
  appendParts(setup, low, most_slices, parts);
  appendParts(setup, high, most_slices, parts);
}

}  // namespace

double mostSlices(const ShaderVariant& variant, size_t channels) {
  return std::max(1.0, kMostTurns / (turnsASample(variant) * static_cast<double>(channels)));
}

std::vector<BoxDraw> cutDeepBoxes(const FrameSetup& setup, std::span<const BoxDraw> boxes,
                                  double most_slices) {
  std::vector<BoxDraw> result;
  result.reserve(boxes.size());
  while (!boxes.empty()) {
    const size_t count = countTogether(boxes);
    const std::span<const BoxDraw> joined = boxes.first(count);
    boxes = boxes.subspan(count);
    // Boxes that are blended together are cut at the same planes, so that the parts still fit
    // together.
    Box3 hull = joined.front().cells;
    for (const BoxDraw& box : joined) hull = unite(hull, box.cells);
    std::vector<Box3> parts;
    appendParts(setup, hull, most_slices, parts);
    for (const Box3& part : parts) {
      bool joins = false;
      for (BoxDraw box : joined) {
        box.cells = intersect(box.cells, part);
        if (box.cells.empty()) continue;
        // The first of each part begins a block, and the others join it.
        box.joins = std::exchange(joins, true);
        result.push_back(box);
      }
    }
  }
  return result;
}

}  // namespace sluice
