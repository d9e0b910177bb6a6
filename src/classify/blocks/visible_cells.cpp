#include "src/classify/blocks/visible_cells.h"

#include <algorithm>
#include <optional>

#include "src/volume/ranges/block_ranges.h"

namespace sluice {
namespace {

// Takes device values; their scale to the transfer function's values may be negative.
template <class T>
bool shows(const TransferFunction& transfer, const ValueMap& map, PlaneRange<T> range) {
  if (range.lo > range.hi) return false;
  // A negative scale turns the range round.
  const double a = map.valueOf(static_cast<double>(range.lo));
  const double b = map.valueOf(static_cast<double>(range.hi));
  return anyOpacity(transfer, std::min(a, b), std::max(a, b));
}

// Most voxel planes along an axis that are looked at one by one: beyond, a brick is a small part.
constexpr int64_t kMostPlanes = int64_t{1} << 22;

// The range of each voxel plane of the volume along an axis, all blocks together, from plane `lo`
// to plane `hi`. The planes reach across the whole volume.
template <class T>
std::vector<PlaneRange<T>> planesOf(const SliceRanges& ranges, int axis, int64_t lo, int64_t hi) {
  const BlockLayout& layout = ranges.layout;
  std::vector<PlaneRange<T>> planes(static_cast<size_t>(hi - lo + 1), kNoVoxels<T>);
  const int64_t first_layer = lo / layout.cells();
  const int64_t end_layer = std::min(layout.grid[axis], hi / layout.cells() + 1);
  std::vector<double> held(static_cast<size_t>(end_layer - first_layer), 0);
  for (size_t i = 0; i < ranges.blocks.size(); ++i) {
    const Vec3i index = layout.indexOf(ranges.blocks[i]);
    const Box3 cells = layout.ownedCells(index);
    const auto own = ranges.planesAs<T>(i, axis);
    if (index[axis] >= first_layer && index[axis] < end_layer)
      ++held[static_cast<size_t>(index[axis] - first_layer)];
    // A plane that two blocks share is widened by both.
    const int64_t end = std::min(cells.hi[axis], hi);
    for (int64_t p = std::max(cells.lo[axis], lo); p <= end; ++p)
      widen(planes[static_cast<size_t>(p - lo)], own[static_cast<size_t>(p - cells.lo[axis])]);
  }
  // Blocks that are not held are nothing but background.
  const double in_layer = static_cast<double>(layout.grid[(axis + 1) % 3]) *
                          static_cast<double>(layout.grid[(axis + 2) % 3]);
  const T background = static_cast<T>(ranges.background);
  for (int64_t layer = first_layer; layer < end_layer; ++layer) {
    // All blocks of the layer are held: no background lies in it.
    if (held[static_cast<size_t>(layer - first_layer)] >= in_layer) continue;
    const int64_t end = std::min((layer + 1) * layout.cells(), hi);
    for (int64_t p = std::max(layer * layout.cells(), lo); p <= end; ++p)
      widen(planes[static_cast<size_t>(p - lo)], {background, background});
  }
  return planes;
}

// The cells that bricks cover, between the first and the last slab along each axis that can show
// anything.
template <class T>
Box3 visibleSlabs(const SliceRanges& ranges, const BrickRanges& bricks,
                  const TransferFunction& transfer) {
  Box3 box = bricks.cells;
  for (int axis = 0; axis < 3 && !box.empty(); ++axis) {
    int64_t lo = box.lo[axis], hi = box.hi[axis];
    // Longer axes keep the bricks' ends, which is close enough.
    if (hi - lo > kMostPlanes) continue;
    const int64_t first = lo;
    const std::vector<PlaneRange<T>> planes = planesOf<T>(ranges, axis, lo, hi);
    const auto slabShows = [&](int64_t slab) {
      PlaneRange<T> range = planes[static_cast<size_t>(slab - first)];
      widen(range, planes[static_cast<size_t>(slab - first + 1)]);
      return shows(transfer, ranges.map, range);
    };
    while (lo < hi && !slabShows(lo)) ++lo;
    while (hi > lo && !slabShows(hi - 1)) --hi;
    box.lo[axis] = lo;
    box.hi[axis] = hi;
  }
  return box;
}

// The first and the last box of a row along x: boxes between them reach no farther.
class Row {
 public:
  void add(const Box3& box) {
    if (!first_) first_ = box;
    last_ = box;
  }
  void addTo(std::vector<Box3>& boxes) const {
    if (first_) boxes.push_back(*first_);
    if (first_ && !(*first_ == last_)) boxes.push_back(last_);
  }

 private:
  std::optional<Box3> first_;
  Box3 last_;
};

// Whether planes cut the box of the bricks that show.
enum class Cut { kByPlanes, kNone };

template <class T>
std::vector<Box3> visibleCellsAs(const SliceRanges& ranges, const BrickRanges& bricks,
                                 const TransferFunction& transfer, const Box3& crop, Cut cut) {
  const Box3 all = boxOf(ranges.layout.dims - Vec3i{1, 1, 1});
  const T background = static_cast<T>(ranges.background);
  // Cells without bricks are background. If it shows, all of the volume may.
  if (bricks.cells != all && shows<T>(transfer, ranges.map, {background, background}))
    return {intersect(crop, all)};
  const Box3 slabs =
      cut == Cut::kByPlanes ? visibleSlabs<T>(ranges, bricks, transfer) : bricks.cells;
  const Box3 inside = intersect(crop, slabs);
  if (inside.empty()) return {};
  const Vec3i grid = bricks.grid();
  const auto each = bricks.rangesAs<T>();
  std::vector<Box3> boxes;
  size_t at = 0;
  // Neighbours often have the same range.
  PlaneRange<T> asked = kNoVoxels<T>;
  bool is_seen = false;
  const auto brickShows = [&](PlaneRange<T> range) {
    if (range.lo != asked.lo || range.hi != asked.hi) {
      asked = range;
      is_seen = shows(transfer, ranges.map, range);
    }
    return is_seen;
  };
  for (int64_t z = 0; z < grid.z; ++z)
    for (int64_t y = 0; y < grid.y; ++y) {
      Row row;
      for (int64_t x = 0; x < grid.x; ++x, ++at) {
        if (!brickShows(each[at])) continue;
        const Box3 cells = intersect(bricks.cellsOf({x, y, z}), inside);
        if (!cells.empty()) row.add(cells);
      }
      row.addTo(boxes);
    }
  return boxes;
}

}  // namespace

std::vector<Box3> visibleCells(const SliceRanges& ranges, const BrickRanges& bricks,
                               const TransferFunction& transfer, const Box3& crop) {
  return visitDeviceType(ranges.map.type, [&](auto tag) {
    return visibleCellsAs<decltype(tag)>(ranges, bricks, transfer, crop, Cut::kByPlanes);
  });
}

std::vector<Box3> visibleBricks(const SliceRanges& ranges, const BrickRanges& bricks,
                                const TransferFunction& transfer, const Box3& crop) {
  return visitDeviceType(ranges.map.type, [&](auto tag) {
    return visibleCellsAs<decltype(tag)>(ranges, bricks, transfer, crop, Cut::kNone);
  });
}

Box3 visiblePlanes(const PlaneRanges& planes, const ValueMap& map,
                   const TransferFunction& transfer) {
  return visitDeviceType(map.type, [&](auto tag) {
    Box3 box;
    for (int axis = 0; axis < 3; ++axis) {
      const auto each = planes.rangesAs<decltype(tag)>(axis);
      const auto isSeen = [&](auto range) { return shows(transfer, map, range); };
      size_t lo = each.size(), hi = 0;
      const auto take = [&](size_t first, size_t last) {
        lo = std::min(lo, first);
        hi = std::max(hi, last + 1);
      };
      for (size_t plane = 0; plane < each.size(); ++plane) {
        if (isSeen(each[plane])) take(plane, plane);
        if (plane + 1 == each.size() || isSeen(each[plane]) || isSeen(each[plane + 1])) continue;
        // Neither shows, but a value between them may.
        auto both = each[plane];
        widen(both, each[plane + 1]);
        if (isSeen(both)) take(plane, plane + 1);
      }
      if (lo >= hi) return Box3{};
      box.lo[axis] = static_cast<int64_t>(lo);
      box.hi[axis] = static_cast<int64_t>(hi);
    }
    return box;
  });
}

bool anyOpacity(const TransferFunction& transfer, double lo, double hi) {
  if (opacityAt(transfer, lo) > 0 || opacityAt(transfer, hi) > 0) return true;
  // The opacity at a point in between, or just below one of two at one value.
  const std::vector<OpacityPoint>& points = transfer.opacities;
  auto point = std::upper_bound(points.begin(), points.end(), lo,
                                [](double v, const OpacityPoint& p) { return v < p.value; });
  for (; point != points.end() && point->value <= hi; ++point)
    if (point->opacity > 0) return true;
  return std::ranges::any_of(transfer.surfaces, [&](const IsoSurface& surface) {
    return surface.opacity > 0 && surface.value >= lo && surface.value <= hi;
  });
}

}  // namespace sluice
