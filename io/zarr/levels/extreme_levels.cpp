#include "io/zarr/levels/extreme_levels.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "src/base/error.h"

namespace sluice {
namespace {

// Columns of a row that are taken together, so that what is kept between them stays in the cache.
constexpr int64_t kColumns = 512;

struct Greater {
  template <class T>
  static bool wins(T a, T b) {
    return a > b;
  }
};
struct Less {
  template <class T>
  static bool wins(T a, T b) {
    return a < b;
  }
};

template <class Order, class T>
T extremeOf(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    // Comparisons with NaN are false: a number takes its place, and it takes nobody's.
    const T other = Order::wins(b, a) || a != a ? b : a;
    return b != b ? a : other;
  } else {
    return Order::wins(b, a) ? b : a;
  }
}

// The rows of finer voxels that a row of blocks stands for; of fewer than four, one stands for the
// others, which changes no extreme.
template <class T>
using FourRows = std::array<const T*, 4>;

// The extremes of the rows, column by column.
template <class Order, class T>
void joinRows(const FourRows<T>& rows, int64_t columns, T* to) {
  const auto [a, b, c, d] = rows;
  for (int64_t x = 0; x < columns; ++x)
    to[x] = extremeOf<Order>(extremeOf<Order>(a[x], b[x]), extremeOf<Order>(c[x], d[x]));
}

template <class Order, class T>
void makeRow(FourRows<T> rows, int64_t finer_columns, int64_t step, T* to) {
  // An axis of wide voxels may not be halved (levelShapes()).
  if (step == 1) return joinRows<Order>(rows, finer_columns, to);
  std::array<T, kColumns> joined;
  const T* const pair = joined.data();
  for (int64_t first = 0; first < finer_columns; first += kColumns) {
    const int64_t columns = std::min(kColumns, finer_columns - first);
    joinRows<Order>(rows, columns, joined.data());
    const int64_t pairs = columns / 2;
    for (int64_t x = 0; x < pairs; ++x) to[x] = extremeOf<Order>(pair[2 * x], pair[2 * x + 1]);
    // All pieces but the last have an even length: a column is left over only at the row's end.
    if (columns % 2 != 0) to[pairs] = pair[columns - 1];
    to += pairs;
    for (const T*& row : rows) row += columns;
  }
}

// A level from the finer voxels; `step`: 1 or 2 of these for one along each axis.
template <class Order, class T>
void makeLevel(const CubeVoxels<T>& finer, Vec3i step, const CubeVoxels<T>& level, T* voxels) {
  for (int64_t z = 0; z < level.size.z; ++z)
    for (int64_t y = 0; y < level.size.y; ++y) {
      FourRows<T> rows{};
      size_t count = 0;
      for (int64_t k = z * step.z; k < std::min((z + 1) * step.z, finer.size.z); ++k)
        for (int64_t j = y * step.y; j < std::min((y + 1) * step.y, finer.size.y); ++j)
          rows[count++] = finer.voxels + k * finer.plane_stride + j * finer.row_stride;
      for (; count < rows.size(); ++count) rows[count] = rows[0];
      makeRow<Order>(rows, finer.size.x, step.x,
                     voxels + z * level.plane_stride + y * level.row_stride);
    }
}

template <class Order, class T>
void makeLevels(const CubeVoxels<T>& cube, std::span<const LevelPart> levels) {
  CubeVoxels<T> finer = cube;
  Vec3i finer_step{1, 1, 1};
  for (const LevelPart& part : levels) {
    T* const voxels = reinterpret_cast<T*>(part.voxels);
    const CubeVoxels<T> level{blocksOf(cube.size, part.step), voxels, part.row_stride,
                              part.plane_stride};
    makeLevel<Order>(finer, part.step / finer_step, level, voxels);
    // Extremes of extremes are exact, so that each level is made from the one before it.
    finer = level;
    finer_step = part.step;
  }
}

}  // namespace

template <class T>
void extremeLevels(const CubeVoxels<T>& cube, std::span<const LevelPart> levels, Downsample how) {
  SLUICE_CHECK(how == Downsample::kMax || how == Downsample::kMin);
  if (how == Downsample::kMax)
    makeLevels<Greater>(cube, levels);
  else
    makeLevels<Less>(cube, levels);
}

// The types of visitVoxelType().
template void extremeLevels(const CubeVoxels<uint8_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<int8_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<uint16_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<int16_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<uint32_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<int32_t>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<float>&, std::span<const LevelPart>, Downsample);
template void extremeLevels(const CubeVoxels<double>&, std::span<const LevelPart>, Downsample);

}  // namespace sluice
