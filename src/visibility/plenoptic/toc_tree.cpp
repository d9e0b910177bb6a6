#include "src/visibility/plenoptic/toc_tree.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int64_t kWordBits = 64;

}  // namespace

TocTree::TocTree(Vec3i grid, int64_t steps)
    : steps_(steps), words_(ceilDiv(std::max<int64_t>(steps, 1), kWordBits)) {
  size_t nodes = 0;
  // Levels halve, rounded up, from the blocks to the root.
  for (Vec3i size = grid;; size = {(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2}) {
    levels_.push_back({size, nodes});
    nodes += static_cast<size_t>(volume(size));
    if (volume(size) <= 1) break;
  }
  bits_.assign(nodes * static_cast<size_t>(words_), 0);
}

TocTree::TocTree(Vec3i grid, int64_t steps, const std::vector<std::vector<int32_t>>& begins)
    : TocTree(grid, steps) {
  SLUICE_CHECK_EQ(static_cast<int64_t>(begins.size()), volume(grid));
  const auto words = static_cast<size_t>(words_);
  for (size_t block = 0; block < begins.size(); ++block)
    for (const int32_t step : begins[block]) {
      SLUICE_CHECK(step >= 0 && step < steps);
      // All blocks begin a span at step 0, so that no change crosses it.
      if (step > 0)
        bits_[block * words + static_cast<size_t>(step / kWordBits)] |= uint64_t{1}
                                                                        << (step % kWordBits);
    }
  // From the leaves up: a node has the bits of all below it.
  for (size_t level = 1; level < levels_.size(); ++level) {
    const Vec3i size = levels_[level].grid;
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y)
        for (int64_t x = 0; x < size.x; ++x)
          sumChildren(level, {x, y, z},
                      std::span(bits_).subspan(nodeAt(levels_[level], {x, y, z}) * words, words));
  }
}

size_t TocTree::nodeAt(const Level& level, Vec3i index) const {
  return level.first +
         static_cast<size_t>((index.z * level.grid.y + index.y) * level.grid.x + index.x);
}

void TocTree::sumChildren(size_t level, Vec3i index, std::span<uint64_t> words) const {
  const Level& below = levels_[level - 1];
  const Box3 children =
      intersect({index * int64_t{2}, index * int64_t{2} + Vec3i{2, 2, 2}}, boxOf(below.grid));
  for (int64_t z = children.lo.z; z < children.hi.z; ++z)
    for (int64_t y = children.lo.y; y < children.hi.y; ++y)
      for (int64_t x = children.lo.x; x < children.hi.x; ++x)
        for (size_t i = 0; i < words.size(); ++i)
          words[i] |= bits_[nodeAt(below, {x, y, z}) * words.size() + i];
}

bool TocTree::beginsWithin(size_t node, int64_t first, int64_t last) const {
  const uint64_t* words = bits_.data() + node * static_cast<size_t>(words_);
  for (int64_t word = first / kWordBits; word <= last / kWordBits; ++word) {
    uint64_t mask = ~uint64_t{0};
    if (word == first / kWordBits) mask &= ~uint64_t{0} << (first % kWordBits);
    if (word == last / kWordBits) mask &= ~uint64_t{0} >> (kWordBits - 1 - last % kWordBits);
    if ((words[word] & mask) != 0) return true;
  }
  return false;
}

std::vector<int64_t> TocTree::changedBetween(int64_t from, int64_t to) const {
  SLUICE_CHECK(from >= 0 && from < steps_ && to >= 0 && to < steps_);
  std::vector<int64_t> changed;
  if (from == to) return changed;
  // Going back in time crosses the same beginnings as going forth.
  const int64_t first = std::min(from, to) + 1, last = std::max(from, to);
  struct Place {
    size_t level;
    Vec3i index;
  };
  // Only nodes in which a span begins between the steps are opened (Gao 2004, section 5.3).
  std::vector<Place> waiting{{levels_.size() - 1, {0, 0, 0}}};
  while (!waiting.empty()) {
    const auto [level, index] = waiting.back();
    waiting.pop_back();
    const size_t node = nodeAt(levels_[level], index);
    if (!beginsWithin(node, first, last)) continue;
    if (level == 0) {
      changed.push_back(static_cast<int64_t>(node));
      continue;
    }
    const Box3 children = intersect({index * int64_t{2}, index * int64_t{2} + Vec3i{2, 2, 2}},
                                    boxOf(levels_[level - 1].grid));
    for (int64_t z = children.lo.z; z < children.hi.z; ++z)
      for (int64_t y = children.lo.y; y < children.hi.y; ++y)
        for (int64_t x = children.lo.x; x < children.hi.x; ++x)
          waiting.push_back({level - 1, {x, y, z}});
  }
  return changed;
}

int64_t TocTree::nodes() const {
  return static_cast<int64_t>(bits_.size()) / words_;
}

}  // namespace sluice
