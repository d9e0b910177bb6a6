#include "src/surface/block_states.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sluice {
namespace {

// A range of device values; none at first.
struct Span {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
};

// The ranges of the blocks that are held, ascending.
template <class F>
void forEachHeld(const SliceRanges& ranges, F f) {
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const auto totals = ranges.totalsAs<decltype(tag)>();
    for (size_t i = 0; i < totals.size(); ++i)
      f(ranges.blocks[i],
        Span{static_cast<double>(totals[i].lo), static_cast<double>(totals[i].hi)});
  });
}

bool isAtBorder(const BlockLayout& layout, int64_t id, const Box3& region) {
  const Box3 cells = layout.ownedCells(layout.indexOf(id));
  for (int a = 0; a < 3; ++a)
    if (cells.lo[a] <= region.lo[a] || cells.hi[a] >= region.hi[a]) return true;
  return false;
}

// Beyond the border of a closed surface, everything is outside.
RangeState stateAt(RangeState state, const BlockLayout& layout, int64_t id, const Box3* closed_at) {
  if (closed_at == nullptr || state == RangeState::kOutside) return state;
  return isAtBorder(layout, id, *closed_at) ? RangeState::kMixed : state;
}

// Adds the states of background blocks, for a surface whose border runs through them.
void addBorder(BlockStates& states, const Box3& region) {
  // Only blocks that differ from the others are listed, whereas the border's blocks must be: all
  // ids are walked through, which a closed surface in a bright background costs.
  std::vector<BlockStates::Block> all;
  auto listed = states.blocks.begin();
  for (int64_t id = 0; id < states.layout.blockCount(); ++id) {
    if (listed != states.blocks.end() && listed->id == id)
      all.push_back(*listed++);
    else if (isAtBorder(states.layout, id, region))
      all.push_back({id, RangeState::kMixed});
  }
  states.blocks = std::move(all);
}

// The blocks of the finest level that voxels of a coarser one are made of, if these lie at the
// corners of the cells of a block.
Box3 finestBlocks(const BlockLayout& finest, const LevelPlacement& placement,
                  const Box3& level_cells) {
  Box3 blocks;
  for (int a = 0; a < 3; ++a) {
    const auto at = [&](int64_t voxel, double beside) {
      return placement.offset[a] + placement.scale[a] * (static_cast<double>(voxel) + beside);
    };
    const double last = static_cast<double>(finest.dims[a] - 1);
    const auto blockAt = [&](double voxel) {
      const auto whole = static_cast<int64_t>(std::clamp(voxel, 0.0, last));
      return std::min(whole / finest.cells(), finest.grid[a] - 1);
    };
    // One coarser voxel more on either side holds all finest voxels that those at the corners are
    // made of.
    blocks.lo[a] = blockAt(std::floor(at(level_cells.lo[a], -1)));
    blocks.hi[a] = blockAt(std::ceil(at(level_cells.hi[a], 1))) + 1;
  }
  return blocks;
}

// The ranges of the finest blocks, for those that ask in any order.
class FinestSpans {
 public:
  explicit FinestSpans(const SliceRanges& ranges) : ranges_(ranges) {
    spans_.reserve(ranges.blocks.size());
    forEachHeld(ranges, [&](int64_t /*id*/, Span span) { spans_.push_back(span); });
  }
  Span of(const Box3& blocks) const {
    Span all;
    for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
      for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) addRow(blocks, y, z, all);
    return all;
  }

 private:
  void addRow(const Box3& blocks, int64_t y, int64_t z, Span& all) const {
    const int64_t first = ranges_.layout.idOf({blocks.lo.x, y, z});
    const int64_t end = first + blocks.size().x;
    auto held = std::lower_bound(ranges_.blocks.begin(), ranges_.blocks.end(), first);
    int64_t count = 0;
    for (; held != ranges_.blocks.end() && *held < end; ++held, ++count)
      widen(all, spans_[static_cast<size_t>(held - ranges_.blocks.begin())]);
    // Blocks that are not held are background, as long as the arrays know all blocks (see the
    // header).
    if (count < blocks.size().x) widen(all, {ranges_.background, ranges_.background});
  }
  static void widen(Span& all, const Span& by) {
    all = {std::min(all.lo, by.lo), std::max(all.hi, by.hi)};
  }

  const SliceRanges& ranges_;
  std::vector<Span> spans_;
};

}  // namespace

RangeState BlockStates::stateOf(int64_t id) const {
  // The blocks ascend by their ids.
  const auto found =
      std::lower_bound(blocks.begin(), blocks.end(), id,
                       [](const Block& block, int64_t other) { return block.id < other; });
  return found != blocks.end() && found->id == id ? found->state : others;
}

BlockStates blockStates(const SliceRanges& ranges, const InsideSet& inside, const Box3* closed_at) {
  BlockStates states{ranges.layout, stateOf(inside, ranges.background, ranges.background), {}};
  forEachHeld(ranges, [&](int64_t id, Span span) {
    const RangeState state =
        stateAt(stateOf(inside, span.lo, span.hi), ranges.layout, id, closed_at);
    if (state != states.others) states.blocks.push_back({id, state});
  });
  // The background is seldom inside.
  if (closed_at != nullptr && states.others == RangeState::kInside) {
    BlockStates held{ranges.layout, states.others, {}};
    forEachHeld(ranges, [&](int64_t id, Span span) {
      held.blocks.push_back(
          {id, stateAt(stateOf(inside, span.lo, span.hi), ranges.layout, id, closed_at)});
    });
    addBorder(held, *closed_at);
    return held;
  }
  return states;
}

BlockStates blockStates(const SliceRanges& finest, const InsideSet& inside, const Box3* closed_at,
                        const BlockLayout& level, const LevelPlacement& placement,
                        LevelValues values) {
  BlockStates states{level, RangeState::kOutside, {}};
  const FinestSpans spans(finest);
  for (int64_t id = 0; id < level.blockCount(); ++id) {
    // No value of the type may reach the threshold. Then no block is mixed, which the conversion of
    // the threshold to the type relies on.
    RangeState state = inside.empty() ? RangeState::kOutside : RangeState::kMixed;
    // Means, extremes and modes lie between the finest voxels. Nothing is known of other levels.
    if (values != LevelValues::kUnknown && finest.unknown.empty()) {
      const Box3 cells = level.ownedCells(level.indexOf(id));
      Span span = spans.of(finestBlocks(finest.layout, placement, cells));
      // A mean of equal floats may miss them by a rounding.
      constexpr double kRounding = 1e-6;
      if (finest.map.type == DeviceType::kF32) {
        span.lo -= kRounding * std::abs(span.lo);
        span.hi += kRounding * std::abs(span.hi);
      }
      state = stateAt(stateOf(inside, span.lo, span.hi), level, id, closed_at);
    }
    if (state != states.others) states.blocks.push_back({id, state});
  }
  return states;
}

}  // namespace sluice
