#include "src/volume/block_layout.h"

#include <algorithm>
#include <bit>

#include "src/base/error.h"

namespace sluice {

BlockLayout blockLayout(Vec3i dims, int64_t size, int ghost, const char* where) {
  SLUICE_CHECK(std::has_single_bit(static_cast<uint64_t>(size)));
  SLUICE_CHECK(ghost >= 0 && ghost <= 3);
  if (dims.x < 2 || dims.y < 2 || dims.z < 2)
    fail("{}: {} x {} x {} voxels: a picture needs at least 2 along each axis", where, dims.x,
         dims.y, dims.z);
  BlockLayout layout{dims, size, ghost, {}};
  SLUICE_CHECK_LE(int64_t{1}, layout.cells());
  int64_t blocks = 1;
  bool countable = true;
  for (int a = 0; a < 3; ++a) {
    // Formula 1 of Tong 1999, ceil((l-1) / (2^d-1)): a block owns 2^d - 1 cells, or fewer if it has
    // ghost layers.
    layout.grid[a] = (dims[a] - 2) / layout.cells() + 1;
    countable = !__builtin_mul_overflow(blocks, layout.grid[a], &blocks) && countable;
  }
  if (!countable)
    failRequest(
        "{}: {} x {} x {} voxels make {} x {} x {} blocks of {}, more than 2^63; give a larger "
        "--block",
        where, dims.x, dims.y, dims.z, layout.grid.x, layout.grid.y, layout.grid.z, size);
  return layout;
}

int64_t blockSizeFor(Vec3i page_vox) {
  // At least 4 voxels, so that a lit block owns a cell between its ghost layers.
  const int64_t longest = std::max({page_vox.x, page_vox.y, page_vox.z, int64_t{4}});
  return static_cast<int64_t>(std::bit_ceil(static_cast<uint64_t>(longest)));
}

}  // namespace sluice
