#include "src/parallel/hilbert.h"

#include <array>
#include <utility>

#include "src/base/error.h"

namespace sluice {

uint64_t hilbertPosition(Vec3i at, int bits) {
  constexpr int kMostBits = 21;
  SLUICE_CHECK(bits >= 0 && bits <= kMostBits);
  std::array<uint64_t, 3> axes{};
  for (int a = 0; a < 3; ++a) {
    SLUICE_CHECK(at[a] >= 0 && at[a] < int64_t{1} << bits);
    axes[static_cast<size_t>(a)] = static_cast<uint64_t>(at[a]);
  }
  if (bits == 0) return 0;
  // From the coarsest octant down: the finer coordinates are turned into the frame of their octant,
  // by mirroring the first axis or by exchanging it with another.
  const uint64_t top = uint64_t{1} << (bits - 1);
  for (uint64_t bit = top; bit > 1; bit >>= 1) {
    const uint64_t below = bit - 1;
    for (uint64_t& axis : axes) {
      if ((axis & bit) != 0) {
        axes[0] ^= below;
      } else {
        const uint64_t exchanged = (axes[0] ^ axis) & below;
        axes[0] ^= exchanged;
        axis ^= exchanged;
      }
    }
  }
  // Octants are visited in the order of a Gray code.
  axes[1] ^= axes[0];
  axes[2] ^= axes[1];
  uint64_t flips = 0;
  // The second half of Skilling's Gray code: each bit of the last axis reverses all finer bits,
  // alike for the three axes.
  for (uint64_t bit = top; bit > 1; bit >>= 1)
    if ((axes[2] & bit) != 0) flips ^= bit - 1;
  uint64_t position = 0;
  for (int bit = bits - 1; bit >= 0; --bit)
    for (const uint64_t axis : axes) position = position << 1 | (((axis ^ flips) >> bit) & 1);
  return position;
}

}  // namespace sluice
