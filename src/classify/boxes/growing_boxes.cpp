#include "src/classify/boxes/growing_boxes.h"

#include <optional>

#include "src/base/error.h"

namespace sluice {
namespace {

bool isFlat(const CellRange& range, const GrowingParameters& parameters) {
  return range.gradient_hi <= parameters.gradient_floor;
}

class Grower {
 public:
  Grower(const BrickGrid& grid, const GrowingParameters& parameters)
      : grid_(grid), parameters_(parameters), taken_(grid.bricks.size()) {}

  std::vector<GrownBox> run() {
    std::vector<GrownBox> boxes;
    // Seeds are the first free bricks in order, so that the result does not depend on anything
    // else.
    for (size_t i = 0; i < taken_.size(); ++i) {
      if (taken_[i] != 0) continue;
      const auto at = static_cast<int64_t>(i);
      const Box3 bricks = grow({at % grid_.size.x, at / grid_.size.x % grid_.size.y,
                                at / (grid_.size.x * grid_.size.y)});
      forRows(bricks, [&](size_t first, size_t count) {
        std::fill_n(taken_.begin() + static_cast<ptrdiff_t>(first), count, uint8_t{1});
        return true;
      });
      boxes.push_back(boxOfBricks(grid_, bricks, parameters_));
    }
    return boxes;
  }

 private:
  struct Growth {
    Box3 bricks;
    CellRange range;
    double cost = 0;
  };

  // Calls f(first brick, count) for each row of the box until it returns false; whether none did.
  template <class F>
  bool forRows(const Box3& box, F&& f) const {
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const auto first = static_cast<size_t>((z * grid_.size.y + y) * grid_.size.x + box.lo.x);
        if (!f(first, static_cast<size_t>(box.size().x))) return false;
      }
    return true;
  }

  Box3 grow(Vec3i seed) const {
    Growth box{{seed, seed + Vec3i{1, 1, 1}}, grid_.at(seed), 0};
    while (const std::optional<Growth> next = bestStep(box)) box = *next;
    return box.bricks;
  }

  std::optional<Growth> bestStep(const Growth& box) const {
    std::optional<Growth> best;
    double best_score = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const bool upwards : {true, false}) {
        const std::optional<Growth> next = step(box, axis, upwards);
        if (!next) continue;
        // Cells and not bricks, since the last brick of an axis may be smaller.
        const int64_t added =
            grid_.cellsOf(next->bricks).count() - grid_.cellsOf(box.bricks).count();
        // The second term decides among equals: it prefers the axis along which the box is shorter.
        const double score = (next->cost - box.cost) / static_cast<double>(added) +
                             1e-3 * static_cast<double>(next->bricks.size()[axis]);
        if (best && score >= best_score) continue;
        best = next;
        best_score = score;
      }
    return best;
  }

  // Nothing if the slab is not free or the box would cost too much.
  std::optional<Growth> step(const Growth& box, int axis, bool upwards) const {
    Growth next = box;
    Box3 slab = box.bricks;
    if (upwards) {
      slab.lo[axis] = box.bricks.hi[axis];
      next.bricks.hi[axis] = slab.hi[axis] = slab.lo[axis] + 1;
    } else {
      slab.hi[axis] = box.bricks.lo[axis];
      next.bricks.lo[axis] = slab.lo[axis] = slab.hi[axis] - 1;
    }
    if (slab.lo[axis] < 0 || slab.hi[axis] > grid_.size[axis] || !isFree(slab)) return std::nullopt;
    next.range = unite(box.range, rangeOf(grid_, slab));
    // If the box's interval stays, its bricks cost what they cost before: only the slab is new.
    const bool as_before = next.range.lo == box.range.lo && next.range.hi == box.range.hi &&
                           isFlat(next.range, parameters_) == isFlat(box.range, parameters_);
    next.cost = as_before ? box.cost + costOf(grid_, slab, next.range, parameters_)
                          : costOf(grid_, next.bricks, next.range, parameters_);
    if (!isWithinLimits(next.cost, grid_.cellsOf(next.bricks).count(), parameters_))
      return std::nullopt;
    return next;
  }

  bool isFree(const Box3& slab) const {
    return forRows(slab, [&](size_t first, size_t count) {
      for (size_t i = first; i < first + count; ++i)
        if (taken_[i] != 0) return false;
      return true;
    });
  }

  const BrickGrid& grid_;
  const GrowingParameters& parameters_;
  std::vector<uint8_t> taken_;  // bricks that a box has
};

}  // namespace

const char* name(BoxType type) {
  switch (type) {
    case BoxType::kUniform:
      return "uniform";
    case BoxType::kGradient:
      return "gradient";
    case BoxType::kOther:
      break;
  }
  return "other";
}

GrowingParameters growingParameters(DeviceType type, ValueRange device_range) {
  GrowingParameters parameters;
  if (type == DeviceType::kU8) return parameters;
  const auto scale = static_cast<float>((device_range.hi - device_range.lo) / 256);
  parameters.uniform_range *= scale;
  parameters.cost_range *= scale;
  parameters.gradient_floor *= scale;
  return parameters;
}

BoxType typeOf(const CellRange& range, int64_t cells, const GrowingParameters& parameters) {
  if (!isFlat(range, parameters)) return BoxType::kGradient;
  const bool uniform =
      range.width() <= parameters.uniform_range && cells >= parameters.least_uniform_cells;
  return uniform ? BoxType::kUniform : BoxType::kOther;
}

double costOf(const BrickGrid& grid, const Box3& bricks, const CellRange& range,
              const GrowingParameters& parameters) {
  const bool flat = isFlat(range, parameters), constant = range.lo == range.hi;
  // A volume of one value has no range to scale by.
  const float per_value = parameters.cost_range > 0 ? 1 / parameters.cost_range : 0;
  const Vec3i cells = grid.cells.size();
  const auto sideAt = [&](int axis, int64_t brick) {
    return std::min(grid.side, cells[axis] - brick * grid.side);
  };
  double sum = 0;
  for (int64_t z = bricks.lo.z; z < bricks.hi.z; ++z)
    for (int64_t y = bricks.lo.y; y < bricks.hi.y; ++y) {
      const CellRange* row = &grid.at({bricks.lo.x, y, z});
      const auto area = static_cast<float>(sideAt(2, z) * sideAt(1, y));
      float of_row = 0;
      for (int64_t i = 0; i < bricks.size().x; ++i) {
        float cost = (range.width() - row[i].width()) * per_value;
        if (!flat && isFlat(row[i], parameters)) cost += parameters.flat_cost;
        if (!constant && row[i].lo == row[i].hi) cost = 1;
        of_row += std::min(1.F, cost) * static_cast<float>(sideAt(0, bricks.lo.x + i));
      }
      sum += static_cast<double>(of_row * area);
    }
  return sum;
}

GrownBox boxOfBricks(const BrickGrid& grid, const Box3& bricks,
                     const GrowingParameters& parameters) {
  const Box3 cells = grid.cellsOf(bricks);
  GrownBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[static_cast<size_t>(axis)] = static_cast<uint16_t>(cells.lo[axis]);
    box.hi[static_cast<size_t>(axis)] = static_cast<uint16_t>(cells.hi[axis]);
  }
  box.range = rangeOf(grid, bricks);
  box.type = typeOf(box.range, cells.count(), parameters);
  return box;
}

std::vector<GrownBox> growBoxes(const BrickGrid& grid, const GrowingParameters& parameters) {
  const Vec3i size = grid.cells.size();
  // Boxes keep their cells in 16 bits.
  SLUICE_CHECK_LT(std::max({size.x, size.y, size.z}), int64_t{1} << 16);
  return Grower(grid, parameters).run();
}

}  // namespace sluice
