#include "src/visibility/plenoptic/block_parts.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sluice {

bool BlockParts::uniform() const {
  return std::all_of(least.begin(), least.end(), [&](float v) { return v == least.front(); });
}

float BlockParts::floor() const {
  return least.empty() ? 0 : *std::min_element(least.begin(), least.end());
}

namespace {

template <class T>
float leastIn(const ExtinctionTable& table, T lo, T hi) {
  // Bytes have a table of all intervals.
  if constexpr (sizeof(T) == 1) return table.leastInBytes(lo, hi);
  return table.leastIn(static_cast<double>(lo), static_cast<double>(hi));
}

// Parts of one cell, the usual ones: minima and maxima over 2 x 2 voxels of a plane serve the cells
// in front of the plane and those behind it.
template <class T>
class CellRanges {
 public:
  CellRanges(int64_t row_stride, Vec3i cells)
      : row_stride_(row_stride),
        cells_(cells),
        lo_(static_cast<size_t>(cells.x * cells.y)),
        hi_(lo_.size()) {}

  // Sets the minima and maxima of the plane whose first voxel is `plane`.
  void set(const T* plane) {
    const auto columns = static_cast<size_t>(cells_.x);
    for (int64_t y = 0; y < cells_.y; ++y) {
      const T* __restrict a = plane + y * row_stride_;
      const T* __restrict b = a + row_stride_;
      T* __restrict lo = lo_.data() + static_cast<size_t>(y) * columns;
      T* __restrict hi = hi_.data() + static_cast<size_t>(y) * columns;
      for (size_t x = 0; x < columns; ++x) {
        lo[x] = std::min(std::min(a[x], a[x + 1]), std::min(b[x], b[x + 1]));
        hi[x] = std::max(std::max(a[x], a[x + 1]), std::max(b[x], b[x + 1]));
      }
    }
  }
  const std::vector<T>& lo() const { return lo_; }
  const std::vector<T>& hi() const { return hi_; }

 private:
  int64_t row_stride_;
  Vec3i cells_;
  std::vector<T> lo_, hi_;  // range of each cell's corners in the plane, x fastest
};

template <class T>
void addCells(const T* voxels, int64_t row_stride, int64_t plane_stride, const PartGrid& grid,
              const ExtinctionTable& table, std::vector<float>& least) {
  CellRanges<T> front(row_stride, grid.cells), behind(row_stride, grid.cells);
  front.set(voxels);
  size_t at = 0;
  for (int64_t z = 0; z < grid.cells.z; ++z) {
    behind.set(voxels + (z + 1) * plane_stride);
    for (size_t i = 0; i < front.lo().size(); ++i, ++at)
      least[at] = leastIn(table, std::min(front.lo()[i], behind.lo()[i]),
                          std::max(front.hi()[i], behind.hi()[i]));
    // The planes take turns: the one behind these cells is in front of the next.
    std::swap(front, behind);
  }
}

}  // namespace

template <class T>
BlockParts blockParts(const T* voxels, int64_t row_stride, int64_t plane_stride,
                      const PartGrid& grid, const ExtinctionTable& table) {
  const Vec3i count = grid.count();
  BlockParts parts{grid, std::vector<float>(static_cast<size_t>(volume(count)))};
  if (grid.side == 1) {
    addCells(voxels, row_stride, plane_stride, grid, table, parts.least);
    return parts;
  }
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
        // The voxels on both faces of a part are its own: its cells lie between them.
        const auto first = cells.lo.x, end = cells.hi.x + 1;
        parts.least[at] = leastIn(table, *std::min_element(lo.begin() + first, lo.begin() + end),
                                  *std::max_element(hi.begin() + first, hi.begin() + end));
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
