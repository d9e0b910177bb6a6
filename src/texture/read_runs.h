// readRuns: which blocks level 3 asks level 2 for together. Pure functions.
//
// Rows of blocks along x lie in the same rows of a file, so blocks of one row are read at once,
// together with those that will be wanted soon.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

struct RunLimits {
  size_t blocks = 1;  // blocks of a run, at most
  size_t runs = 1;    // at once, at most
};
// The limits for `threads` reading threads and a level 2 that holds `level_blocks`. The runs in
// flight together stay within half of it, so that blocks read along with their row are still there
// when their turn comes. They may take seven eighths if that allows two whole rows, each of which
// lies contiguous in a file.
RunLimits runLimits(size_t level_blocks, int64_t blocks_a_row, size_t threads);

struct ReadRun {
  std::vector<int64_t> blocks;  // ids, ascending, of one row
  size_t from = 0, to = 0;      // positions in `wanted` that these blocks serve: [from, to)
};

// `wanted` and `soon` are ids of blocks, ascending; they may repeat. `blocks_a_row` is the grid's
// size along x; a run has at most `most` blocks. Each wanted block is in exactly one run; one that
// is only wanted soon is in a run of its row, or in none.
std::vector<ReadRun> readRuns(std::span<const int64_t> wanted, std::span<const int64_t> soon,
                              int64_t blocks_a_row, size_t most);

}  // namespace sluice
