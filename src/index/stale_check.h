// StaleCheck: compares blocks, as they are read, with the min-max arrays that said what they hold.
// Blocks that are drawn pass through StaleCheck itself; the passes that make opacity functions and
// growing boxes, which read voxels of their own, call expectSameValues().
//
// An index is believed if the identity of the volume's files is the one that it was made of. Some
// changes leave that identity as it is: a chunk of a store of millions that is rewritten in place,
// a file system without honest times. The first block that is read with another range than in the
// arrays proves such a change: the picture fails, and the indices of the volume are removed, so
// that the next opening makes them again. A block that a wrong index calls empty is not read and
// proves nothing. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "src/base/threads/mutex.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

// The least and the greatest device value of a block's own voxels.
struct BlockValues {
  double lo = 0, hi = 0;
  friend bool operator==(const BlockValues&, const BlockValues&) = default;
};
// Returns the values that the arrays tell of a block.
BlockValues expectedValues(const SliceRanges& ranges, int64_t block);

// Where the expected values came from, and how to print them.
struct ExpectedOrigin {
  std::string volume;  // name, for messages
  ValueMap map;
  std::filesystem::path index_file;  // empty: the arrays were made from the voxels
};
// Checks blocks that are read past the volume buffer. Throws Error if the values differ, and
// removes the volume's indices.
void expectSameValues(const BlockName& name, const BlockValues& found, const BlockValues& expected,
                      const ExpectedOrigin& origin);

class StaleCheck {
 public:
  // `name`: the volume's, for messages.
  explicit StaleCheck(std::string name) : name_(std::move(name)) {}

  // Sets the arrays that the blocks of a grid are compared with, as long as someone else holds
  // them. `grid`: the name of any of its blocks.
  void expect(const BlockName& grid, const std::shared_ptr<const SliceRanges>& ranges);

  // Throws Error when the block contradicts the arrays of its grid. Blocks of other grids, and
  // those whose values the arrays do not know, pass.
  void check(const BlockName& name, const VolumeBlock& block) const;

 private:
  const std::string name_;
  mutable Mutex mutex_;
  // The arrays by the name of each grid's block 0.
  std::map<BlockName, std::weak_ptr<const SliceRanges>> expected_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
