#include "src/render/blocks/range_tree.h"

#include <algorithm>

namespace sluice {
namespace {

void widen(RangeTree::Node& node, const RangeTree::Node& by) {
  node.has_unknown = node.has_unknown || by.has_unknown;
  if (by.lo > by.hi) return;
  const bool is_first = node.lo > node.hi;
  node.lo = is_first ? by.lo : std::min(node.lo, by.lo);
  node.hi = is_first ? by.hi : std::max(node.hi, by.hi);
}

// The finest level's blocks, a row of them along x at a time: that needs one search in the list of
// those that are held.
template <class T>
class FinestRows {
 public:
  explicit FinestRows(const SliceRanges& ranges) : ranges_(ranges), totals_(ranges.totalsAs<T>()) {}

  // The blocks from `lo` to `hi` along x of a row.
  RangeTree::Node of(int64_t lo, int64_t hi, int64_t y, int64_t z) const {
    RangeTree::Node node;
    const int64_t first = ranges_.layout.idOf({lo, y, z}), end = first + hi - lo;
    const auto& held = ranges_.blocks;
    auto at = std::ranges::lower_bound(held, first);
    int64_t known = 0;
    for (; at != held.end() && *at < end; ++at, ++known) {
      const PlaneRange<T>& total = totals_[static_cast<size_t>(at - held.begin())];
      widen(node, {static_cast<float>(total.lo), static_cast<float>(total.hi), false});
    }
    for (int64_t block = first; known < hi - lo && block < end; ++block) {
      if (std::ranges::binary_search(held, block)) continue;
      ++known;
      const auto background = static_cast<float>(ranges_.background);
      if (ranges_.isKnown(block))
        widen(node, {background, background, false});
      else
        node.has_unknown = true;
    }
    return node;
  }

 private:
  const SliceRanges& ranges_;
  const std::span<const PlaneRange<T>> totals_;
};

// All nodes of a level, on all threads of the pool.
template <class Of>
std::vector<RangeTree::Node> levelOf(const PyramidLayout& pyramid, int level, WorkerPool& pool,
                                     const Of& of) {
  constexpr int64_t kPart = 512;
  const BlockLayout& blocks = pyramid.level(level).blocks;
  std::vector<RangeTree::Node> nodes(static_cast<size_t>(blocks.blockCount()));
  pool.parallelFor((blocks.blockCount() + kPart - 1) / kPart, [&](int64_t part) {
    const int64_t end = std::min(blocks.blockCount(), (part + 1) * kPart);
    for (int64_t block = part * kPart; block < end; ++block)
      nodes[static_cast<size_t>(block)] = of(pyramid.childrenOf(level, blocks.indexOf(block)));
  });
  return nodes;
}

}  // namespace

RangeTree::RangeTree(const SliceRanges& finest, const PyramidLayout& pyramid, WorkerPool& pool) {
  if (pyramid.levels() < 2) return;
  levels_.push_back(visitDeviceType(finest.map.type, [&](auto tag) {
    const FinestRows<decltype(tag)> rows(finest);
    return levelOf(pyramid, 1, pool, [&](const Box3& children) {
      Node node;
      for (int64_t z = children.lo.z; z < children.hi.z; ++z)
        for (int64_t y = children.lo.y; y < children.hi.y; ++y)
          widen(node, rows.of(children.lo.x, children.hi.x, y, z));
      return node;
    });
  }));
  for (int level = 2; level < pyramid.levels(); ++level)
    levels_.push_back(levelOf(pyramid, level, pool, [&](const Box3& children) {
      Node node;
      const BlockLayout& below = pyramid.level(level - 1).blocks;
      for (int64_t z = children.lo.z; z < children.hi.z; ++z)
        for (int64_t y = children.lo.y; y < children.hi.y; ++y)
          for (int64_t x = children.lo.x; x < children.hi.x; ++x)
            widen(node, of(level - 1, below.idOf({x, y, z})));
      return node;
    }));
}

}  // namespace sluice
