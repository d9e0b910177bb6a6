#include "src/texture/read_runs.h"

#include <algorithm>

namespace sluice {

RunLimits runLimits(size_t level_blocks, int64_t blocks_a_row, size_t threads) {
  const auto row = static_cast<size_t>(blocks_a_row);
  // Half of level 2, so that the blocks that were read along are still there when their turn comes.
  const size_t each = std::max<size_t>(1, level_blocks / 2 / threads);
  const size_t rows = level_blocks * 7 / 8 / row;
  // A thread's share is less than a row: fewer threads then read whole rows, which lie together in
  // a file.
  if (each < row && rows >= 2) return {row, std::min(rows, threads)};
  return {each, threads};
}

std::vector<ReadRun> readRuns(std::span<const int64_t> wanted, std::span<const int64_t> soon,
                              int64_t blocks_a_row, size_t most) {
  std::vector<ReadRun> runs;
  for (size_t from = 0; from < wanted.size();) {
    // A run never crosses a row: the next row lies elsewhere in the file.
    const int64_t row = wanted[from] / blocks_a_row * blocks_a_row, row_end = row + blocks_a_row;
    std::vector<int64_t> blocks(std::lower_bound(soon.begin(), soon.end(), row),
                                std::lower_bound(soon.begin(), soon.end(), row_end));
    size_t to = from;
    for (; to < wanted.size() && wanted[to] < row_end; ++to) blocks.push_back(wanted[to]);
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    // Splits into parts of at most `most` blocks, and keeps the parts that serve someone.
    for (size_t part = 0; part < blocks.size() && from < to; part += most) {
      const size_t part_end = std::min(part + most, blocks.size());
      ReadRun run{.blocks = {blocks.begin() + static_cast<ptrdiff_t>(part),
                             blocks.begin() + static_cast<ptrdiff_t>(part_end)},
                  .from = from,
                  .to = from};
      while (run.to < to && wanted[run.to] <= run.blocks.back()) ++run.to;
      // None of these blocks is wanted now: they would be read for nothing.
      if (run.to == from) continue;
      from = run.to;
      runs.push_back(std::move(run));
    }
  }
  return runs;
}

}  // namespace sluice
