#include "src/visibility/block_parts.h"

#include <algorithm>
#include <limits>

namespace sluice {

bool BlockParts::uniform() const {
  return std::all_of(least.begin(), least.end(), [&](float v) { return v == least.front(); });
}

float BlockParts::floor() const {
  return least.empty() ? 0 : *std::min_element(least.begin(), least.end());
}

template <class T>
BlockParts blockParts(const T* voxels, int64_t row_stride, int64_t plane_stride,
                      const PartGrid& grid, const ExtinctionTable& table) {
  const Vec3i count = grid.count();
  BlockParts parts{grid, std::vector<float>(static_cast<size_t>(volume(count)))};
  // Column by column of the block first: element by element is what vector units like.
  std::vector<T> lo(static_cast<size_t>(grid.cells.x + 1)), hi(lo.size());
  size_t at = 0;
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y) {
      const Box3 row = grid.cellsOf({0, y, z});
      std::fill(lo.begin(), lo.end(), std::numeric_limits<T>::max());
      std::fill(hi.begin(), hi.end(), std::numeric_limits<T>::lowest());
      for (int64_t vz = row.lo.z; vz <= row.hi.z; ++vz)
        for (int64_t vy = row.lo.y; vy <= row.hi.y; ++vy) {
          const T* from = voxels + vz * plane_stride + vy * row_stride;
          T* least = lo.data();
          T* most = hi.data();
          for (size_t x = 0; x < lo.size(); ++x) {
            least[x] = std::min(least[x], from[x]);
            most[x] = std::max(most[x], from[x]);
          }
        }
      for (int64_t x = 0; x < count.x; ++x, ++at) {
        const Box3 cells = grid.cellsOf({x, y, z});
        const auto first = cells.lo.x, end = cells.hi.x + 1;
        parts.least[at] = table.leastIn(
            static_cast<double>(*std::min_element(lo.begin() + first, lo.begin() + end)),
            static_cast<double>(*std::max_element(hi.begin() + first, hi.begin() + end)));
      }
    }
  return parts;
}

template BlockParts blockParts(const uint8_t*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&);
template BlockParts blockParts(const uint16_t*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&);
template BlockParts blockParts(const float*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&);

BlockParts uniformParts(double device, const PartGrid& grid, const ExtinctionTable& table) {
  return {grid, std::vector<float>(static_cast<size_t>(volume(grid.count())),
                                   table.leastIn(device, device))};
}

}  // namespace sluice
