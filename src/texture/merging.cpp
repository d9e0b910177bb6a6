#include "src/texture/merging.h"

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

namespace sluice {
namespace {

constexpr std::array<std::string_view, 2> kOrderNames = {"paper", "first-fit"};

Column columnOf(const MergeBlock& block) {
  return {{block}, block.thickness};
}

// Side by side; a brace list would copy the columns.
MergedChunk chunkOf(Column left, Column right) {
  MergedChunk chunk;
  chunk.columns.reserve(2);
  chunk.columns.push_back(std::move(left));
  chunk.columns.push_back(std::move(right));
  return chunk;
}
MergedChunk chunkOf(Column only) {
  MergedChunk chunk;
  chunk.columns.push_back(std::move(only));
  return chunk;
}

uint64_t placeOf(const Column& column) {
  return column.blocks.front().place;
}

// Pairs columns of one thickness, neighbours first: those in one cell of a grid, then in one cell
// of the grid of twice its cells' size, and so on. Returns the one that is left alone, if any. A
// column more or less changes one pair of each grid at most.
std::optional<Column> pairNeighbors(std::vector<Column> columns, std::vector<MergedChunk>& chunks) {
  std::stable_sort(columns.begin(), columns.end(),
                   [](const Column& a, const Column& b) { return placeOf(a) < placeOf(b); });
  // A shift by all bits in which the places differ puts all columns in one cell, so that at most
  // one stays alone.
  const int bits = std::bit_width(placeOf(columns.back()) ^ placeOf(columns.front()));
  for (int shift = 0; shift <= bits && columns.size() > 1; ++shift) {
    const auto cellOf = [&](const Column& column) {
      // A shift by the width of the type is undefined.
      return shift < std::numeric_limits<uint64_t>::digits ? placeOf(column) >> shift : 0;
    };
    std::vector<Column> alone;
    for (size_t i = 0; i < columns.size(); ++i) {
      if (i + 1 < columns.size() && cellOf(columns[i]) == cellOf(columns[i + 1])) {
        chunks.push_back(chunkOf(std::move(columns[i]), std::move(columns[i + 1])));
        ++i;
      } else {
        alone.push_back(std::move(columns[i]));
      }
    }
    columns = std::move(alone);
  }
  return columns.empty() ? std::nullopt : std::optional(std::move(columns.front()));
}

// Pairs all columns of equal thickness, as the least difference goes first, and returns the others.
// Requires: sorted by thickness.
std::vector<Column> pairEquals(std::vector<Column> columns, std::vector<MergedChunk>& chunks) {
  std::vector<Column> others;
  for (auto first = columns.begin(); first != columns.end();) {
    const auto last = std::find_if(first, columns.end(), [&](const Column& column) {
      return column.thickness != first->thickness;
    });
    if (auto alone = pairNeighbors({std::move_iterator(first), std::move_iterator(last)}, chunks))
      others.push_back(*std::move(alone));
    first = last;
  }
  return others;
}

// Takes the pair of columns with the least difference in thickness, again and again, until at most
// one is left alone. Neighbours in sorted order are the only candidates, and stay so as pairs go.
std::vector<MergedChunk> pairByThickness(std::vector<Column> columns) {
  std::stable_sort(columns.begin(), columns.end(),
                   [](const Column& a, const Column& b) { return a.thickness < b.thickness; });
  std::vector<MergedChunk> chunks;
  chunks.reserve((columns.size() + 1) / 2);
  columns = pairEquals(std::move(columns), chunks);
  const size_t count = columns.size();
  // A linked list over the sorted columns: when a pair goes, the columns on its two sides become
  // neighbours.
  std::vector<size_t> before(count), after(count);  // count: none
  std::vector<bool> taken(count, false);
  using Pair = std::tuple<int64_t, size_t, size_t>;  // difference, lower, upper
  std::vector<Pair> room;
  room.reserve(count);
  // The capacity is reserved beforehand, so the queue does not grow while the first offers are
  // made.
  std::priority_queue pairs(std::greater<>(), std::move(room));
  const auto offer = [&](size_t a, size_t b) {
    pairs.emplace(columns[b].thickness - columns[a].thickness, a, b);
  };
  for (size_t i = 0; i < count; ++i) {
    before[i] = i == 0 ? count : i - 1;
    after[i] = i + 1;
    if (i + 1 < count) offer(i, i + 1);
  }
  while (!pairs.empty()) {
    const auto [difference, a, b] = pairs.top();
    pairs.pop();
    // An offer is out of date if one of its columns was paired meanwhile.
    if (taken[a] || taken[b]) continue;
    taken[a] = taken[b] = true;
    const size_t left = before[a], right = after[b];
    if (left < count) after[left] = right;
    if (right < count) before[right] = left;
    if (left < count && right < count) offer(left, right);
    chunks.push_back(chunkOf(std::move(columns[a]), std::move(columns[b])));
  }
  for (size_t i = 0; i < count; ++i)
    if (!taken[i]) chunks.push_back(chunkOf(std::move(columns[i])));
  return chunks;
}

// Piles a chunk of one block on the column, of all chunks', that it fills best.
void pileUpLeftover(std::vector<MergedChunk>& chunks, int64_t limit) {
  const auto alone = std::find_if(chunks.begin(), chunks.end(),
                                  [](const MergedChunk& chunk) { return chunk.isSingleBlock(); });
  if (alone == chunks.end()) return;
  const MergeBlock block = alone->columns[0].blocks[0];
  Column* best = nullptr;
  for (MergedChunk& chunk : chunks) {
    if (&chunk == &*alone) continue;
    for (Column& column : chunk.columns)
      if (column.thickness + block.thickness <= limit &&
          (best == nullptr || column.thickness > best->thickness))
        best = &column;
  }
  if (best == nullptr) return;
  best->blocks.push_back(block);
  best->thickness += block.thickness;
  // `best` may point behind the erased chunk, so the block was added before.
  chunks.erase(alone);
}

// First-fit decreasing by height.
std::vector<Column> pileUp(std::vector<MergeBlock> blocks, int64_t limit) {
  std::stable_sort(blocks.begin(), blocks.end(), [](const MergeBlock& a, const MergeBlock& b) {
    return a.thickness > b.thickness;
  });
  std::vector<Column> columns;
  // Columns before this are too high for any block still to come.
  size_t first_open = 0;
  for (const MergeBlock& block : blocks) {
    const int64_t thinnest = blocks.back().thickness;
    // Blocks come thickest first. A column that is too high for the thinnest one is too high for
    // all that follow, so that the search need not begin at the first column each time.
    while (first_open < columns.size() && columns[first_open].thickness + thinnest > limit)
      ++first_open;
    size_t at = first_open;
    while (at < columns.size() && columns[at].thickness + block.thickness > limit) ++at;
    if (at == columns.size()) columns.push_back({});
    columns[at].blocks.push_back(block);
    columns[at].thickness += block.thickness;
  }
  return columns;
}

}  // namespace

std::string_view name(MergeOrder order) {
  return kOrderNames[static_cast<size_t>(order)];
}

int64_t MergedChunk::thickness() const {
  int64_t most = 0;
  for (const Column& column : columns) most = std::max(most, column.thickness);
  return most;
}

std::vector<MergedChunk> mergeInCluster(const std::vector<MergeBlock>& blocks, int64_t limit,
                                        MergeOrder order) {
  if (order == MergeOrder::kFirstFit) return pairByThickness(pileUp(blocks, limit));
  std::vector<Column> columns;
  columns.reserve(blocks.size());
  for (const MergeBlock& block : blocks) columns.push_back(columnOf(block));
  std::vector<MergedChunk> chunks = pairByThickness(std::move(columns));
  // Horizontal merges leave at most one block alone.
  pileUpLeftover(chunks, limit);
  return chunks;
}

MergedChunk mergeBetweenClusters(const MergeBlock& a, const MergeBlock& b, int64_t limit,
                                 MergeOrder order) {
  if (order == MergeOrder::kFirstFit && a.thickness + b.thickness <= limit)
    return {{{{a, b}, a.thickness + b.thickness}}};
  return chunkOf(columnOf(a), columnOf(b));
}

}  // namespace sluice
