// Merging of texture blocks into chunks (Tong 1999, section 3.2.3), on thicknesses alone.
//
// A chunk is one or two columns side by side along texture x or y; a column is a pile of texture
// blocks along z, no higher than a volume block. The paper's operations:
//   horizontal  two blocks become the two columns of a chunk, as thick as the thicker one; the room
//               above the thinner one is the extended part
//   vertical    two blocks pile up if their thicknesses fit under 2^d; a block piles on a column
//               of a merged chunk likewise, the extended part excluded first
// The paper leaves open which of several blocks of one thickness merge. Ours are neighbours, so
// that a block that appears or goes changes the chunks near it and few others. Pure functions; the
// caller may number blocks as it likes.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace sluice {

// The order of the operations changes the result (section 3.2.3.4).
enum class MergeOrder {
  // The paper's: horizontal merges in ascending order of thickness difference first, then vertical.
  kPaper,
  // Ours: blocks in descending order of thickness go into the first column that still has room
  // (first-fit decreasing by height), then columns of like height go side by side.
  kFirstFit,
};
inline constexpr std::array kMergeOrders = {MergeOrder::kPaper, MergeOrder::kFirstFit};
std::string_view name(MergeOrder order);  // "paper", "first-fit"

struct MergeBlock {
  int64_t block = 0;
  int64_t thickness = 0;  // texels, 1 to 2^d
  uint64_t place = 0;     // the more leading bits two blocks share, the nearer they are
};

struct Column {
  std::vector<MergeBlock> blocks;  // from below
  int64_t thickness = 0;
};

struct MergedChunk {
  std::vector<Column> columns;  // 1 or 2
  // Texels: the thickness of its thicker column.
  int64_t thickness() const;
  bool isSingleBlock() const { return columns.size() == 1 && columns[0].blocks.size() == 1; }
};

// Merges within a cluster (3.2.3.2). `limit` is 2^d, no less than any thickness. Deterministic:
// ties go by place, then by the order of `blocks`. O(n log n) for the paper's order.
std::vector<MergedChunk> mergeInCluster(const std::vector<MergeBlock>& blocks, int64_t limit,
                                        MergeOrder order);

// Between two clusters (3.2.3.3): a chunk of two blocks that stayed alone, side by side in the
// paper's order, which merges horizontally before vertically, piled up if they fit under `limit` in
// ours.
MergedChunk mergeBetweenClusters(const MergeBlock& a, const MergeBlock& b, int64_t limit,
                                 MergeOrder order);

}  // namespace sluice
