#include "io/zarr/levels/narrow_means.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <type_traits>

#include "io/zarr/levels/block_sums.h"
#include "io/zarr/levels/byte_blocks.h"
#include "io/zarr/levels/short_blocks.h"
#include "src/base/wide_vectors.h"

namespace sluice {
namespace {

// The rows of numbers that a row of blocks is made of: one, or two neighbours along y or z, or two
// of each of two planes.
template <class In>
struct FinerRows {
  std::array<const In*, 4> row{};
  size_t count = 0;
};

// out[x]: the sum of f() over the numbers of block x, kStep of each of kRows rows.
template <size_t kRows, int64_t kStep, class Sum, class In, class F, class Out>
void addBlocks(const FinerRows<In>& rows, int64_t blocks, F f, Out* __restrict out) {
  std::array<const In*, kRows> row;
  std::copy_n(rows.row.begin(), kRows, row.begin());
  for (int64_t x = 0; x < blocks; ++x) {
    Sum sum = 0;
    for (size_t r = 0; r < kRows; ++r)
      for (int64_t i = 0; i < kStep; ++i) sum = static_cast<Sum>(sum + f(row[r][x * kStep + i]));
    out[x] = static_cast<Out>(sum);
  }
}

// The same for rows of `size` numbers, with a last block that may be narrower.
// The first `made` blocks are there already.
template <class Sum, class In, class F, class Out>
void addRows(FinerRows<In> rows, int64_t size, int64_t step, F f, Out* out, int64_t made = 0) {
  for (size_t r = 0; r < rows.count; ++r) rows.row[r] += made * step;
  size -= made * step;
  out += made;
  const int64_t whole = size / step;
  const auto addWhole = [&]<int64_t kStep>(std::integral_constant<int64_t, kStep>) {
    if (rows.count == 4) return addBlocks<4, kStep, Sum>(rows, whole, f, out);
    if (rows.count == 2) return addBlocks<2, kStep, Sum>(rows, whole, f, out);
    addBlocks<1, kStep, Sum>(rows, whole, f, out);
  };
  if (step == 1) return addWhole(std::integral_constant<int64_t, 1>());
  addWhole(std::integral_constant<int64_t, 2>());
  if (size % 2 == 0) return;
  Sum sum = 0;
  for (size_t r = 0; r < rows.count; ++r) sum = static_cast<Sum>(sum + f(rows.row[r][size - 1]));
  out[whole] = static_cast<Out>(sum);
}

// Means and spreads of blocks of `count` voxels, a power of two. Real must hold the sums, divided
// by the count, and the square of a mean exactly.
template <class Real, class T, class Sum, class Square>
void finishBlocks(const Sum* __restrict sums, const Square* __restrict squares, int64_t blocks,
                  int64_t count, T* __restrict means, SpreadOf<T>* __restrict spreads) {
  const Real share = Real{1} / static_cast<Real>(count);
  for (int64_t x = 0; x < blocks; ++x) {
    const Real mean = static_cast<Real>(sums[x]) * share;
    const Real variance = static_cast<Real>(squares[x]) * share - mean * mean;
    const Real spread = 2 * std::sqrt(std::max(Real{0}, variance));
    means[x] = static_cast<T>(static_cast<int32_t>(rounded(mean)));
    spreads[x] = static_cast<SpreadOf<T>>(static_cast<int32_t>(rounded(spread)));
  }
}

// Sums of the blocks of one plane, x fastest.
template <class Sum, class Square>
struct Plane {
  Sum* sums = nullptr;
  Square* squares = nullptr;
};
// The last two planes of a level, an even one first.
template <class Sum, class Square>
using Planes = std::array<Plane<Sum, Square>, 2>;

// Squares of a block of the first level: eight of 8 bits, or eight of 16 bits.
template <class T>
using FirstSquare = std::conditional_t<sizeof(T) == 1, int32_t, uint64_t>;
// Sums and squares of a block of the second level: of 64 voxels. Those of 8 bits are below 2^23.
template <class T>
using SecondNumber = std::conditional_t<sizeof(T) == 1, int32_t, double>;

template <class T>
class Pass {
 public:
  Pass(const CubeVoxels<T>& cube, std::span<const LevelPart> levels, std::vector<std::byte>& room)
      : cube_(cube), levels_(levels), coarser_(levels.size()) {
    std::vector<Vec3i> steps;
    for (const LevelPart& level : levels) {
      steps.push_back(level.step);
      sizes_.push_back(blocksOf(cube.size, level.step));
    }
    // Never smaller: the room serves cubes of all sizes, one after the other.
    room.resize(std::max<size_t>(room.size(), narrowMeansRoom(cube.size, steps)));
    std::byte* next = room.data();
    const auto take = [&]<class Number>(Number*& to, size_t level) {
      to = reinterpret_cast<Number*>(next);
      next += static_cast<size_t>(sizes_[level].x * sizes_[level].y) * sizeof(Number);
    };
    const auto takePlanes = [&](auto& planes, size_t level) {
      // Wide numbers first, so that all of them are aligned.
      for (auto& plane : planes) take(plane.squares, level);
      for (auto& plane : planes) take(plane.sums, level);
    };
    for (size_t level = levels.size() - 1; level > 1; --level) takePlanes(coarser_[level], level);
    if (levels.size() > 1) takePlanes(second_, 1);
    takePlanes(first_, 0);
  }

  void run() {
    for (int64_t z = 0; z < sizes_.front().z; ++z) {
      makeFirst(z);
      makeCoarserOf(z);
    }
  }

 private:
  // A plane of the first level.
  void makeFirst(int64_t z) {
    const Vec3i step = levels_.front().step;
    const auto rowAt = [&](int64_t pz, int64_t py) {
      return cube_.voxels + pz * cube_.plane_stride + py * cube_.row_stride;
    };
    const Plane<int32_t, FirstSquare<T>> to = first_[static_cast<size_t>(z % 2)];
    for (int64_t y = 0; y < sizes_.front().y; ++y) {
      const auto rows = rowsOf<T>(cube_.size, step, y, z, rowAt);
      int32_t* const sums = to.sums + y * sizes_.front().x;
      FirstSquare<T>* const squares = to.squares + y * sizes_.front().x;
      int64_t made = 0;
      if constexpr (std::is_same_v<T, uint8_t>) {
        if (hasBlocksOf64(y / 2, z / 2)) {
          // Rows of the first level come one by one, but four of them are made at once, at the
          // first one.
          if (y % 2 == 0 && z % 2 == 0) makeTwoLevels(y / 2, z / 2);
          made = 2 * made_of_64_;
        } else if (rows.count == 4 && step.x == 2) {
          made = makeByteBlocks(rows.row, y, z);
        }
      }
      if constexpr (sizeof(T) == 2)
        if (rows.count == 4 && step.x == 2) made = makeShorts(rows.row, y, z, sums, squares);
      using Narrow = std::conditional_t<sizeof(T) == 1, int16_t, int32_t>;
      addRows<Narrow>(
          rows, cube_.size.x, step.x, [](T v) { return Narrow{v}; }, sums, made);
      addRows<FirstSquare<T>>(
          rows, cube_.size.x, step.x,
          [](T v) {
            // A square of 16 bits fits into 32 without a sign.
            const auto wide = static_cast<uint32_t>(int32_t{v});
            const uint32_t square = wide * wide;
            return static_cast<FirstSquare<T>>(square);
          },
          squares, made);
      // Eight values of 8 bits: all products are below 2^24.
      finishRow<std::conditional_t<sizeof(T) == 1, float, double>>(0, y, z, sums, squares, made);
    }
  }

  // The first blocks of a row of the first level; returns how many.
  int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& rows, int64_t y, int64_t z) const {
    const LevelPart& part = levels_.front();
    const int64_t at = z * part.plane_stride + y * part.row_stride;
    const auto& plane = first_[static_cast<size_t>(z % 2)];
    const int64_t row = y * sizes_.front().x;
    return sluice::makeByteBlocks(
        rows, cube_.size.x / 2,
        {plane.sums + row, plane.squares + row, reinterpret_cast<uint8_t*>(part.voxels) + at,
         reinterpret_cast<uint8_t*>(part.spreads) + at});
  }

  int64_t makeShorts(const std::array<const T*, 4>& rows, int64_t y, int64_t z, int32_t* sums,
                     uint64_t* squares) const {
    const LevelPart& part = levels_.front();
    const int64_t at = z * part.plane_stride + y * part.row_stride;
    return makeShortBlocks<T>(rows, cube_.size.x / 2,
                              {sums, squares, reinterpret_cast<T*>(part.voxels) + at,
                               reinterpret_cast<uint16_t*>(part.spreads) + at});
  }

  // Whether a row of the second level is of blocks of 4 x 4 x 4 voxels, but for the last ones.
  bool hasBlocksOf64(int64_t y, int64_t z) const {
    return levels_.size() > 1 && levels_[0].step == Vec3i{2, 2, 2} &&
           levels_[1].step == Vec3i{4, 4, 4} && (y + 1) * 4 <= cube_.size.y &&
           (z + 1) * 4 <= cube_.size.z;
  }
  // The first blocks of such a row, and of the four rows of the first level below it. The sums of
  // the latter are not kept: nothing else needs them.
  void makeTwoLevels(int64_t y, int64_t z) {
    std::array<const uint8_t*, 16> rows{};
    TwoLevelsOfBytes to;
    const LevelPart &finer = levels_[0], &coarser = levels_[1];
    for (size_t row = 0; row < 4; ++row) {
      const int64_t py = 2 * y + static_cast<int64_t>(row % 2);
      const int64_t pz = 2 * z + static_cast<int64_t>(row / 2);
      const int64_t at = pz * finer.plane_stride + py * finer.row_stride;
      to.means[row] = reinterpret_cast<uint8_t*>(finer.voxels) + at;
      to.spreads[row] = reinterpret_cast<uint8_t*>(finer.spreads) + at;
      for (size_t i = 0; i < 4; ++i)
        rows[4 * row + i] = cube_.voxels +
                            (2 * pz + static_cast<int64_t>(i / 2)) * cube_.plane_stride +
                            (2 * py + static_cast<int64_t>(i % 2)) * cube_.row_stride;
    }
    const auto& plane = second_[static_cast<size_t>(z % 2)];
    const int64_t at = z * coarser.plane_stride + y * coarser.row_stride;
    const int64_t row = y * sizes_[1].x;
    to.coarser_sums = plane.sums + row;
    to.coarser_squares = plane.squares + row;
    to.coarser_means = reinterpret_cast<uint8_t*>(coarser.voxels) + at;
    to.coarser_spreads = reinterpret_cast<uint8_t*>(coarser.spreads) + at;
    made_of_64_ = makeTwoLevelsOfBytes(rows, cube_.size.x / 4, to);
  }

  // The planes of coarser levels that end with plane z of the first one.
  void makeCoarserOf(int64_t z) {
    for (size_t level = 1; level < levels_.size(); ++level) {
      const int64_t step = levels_[level].step.z / levels_[level - 1].step.z;
      // A plane waits for its sibling, except the last of an odd number.
      if ((z + 1) % step != 0 && z + 1 < sizes_[level - 1].z) return;
      z /= step;
      if (level == 1)
        makeCoarser(level, z, first_, second_);
      else if (level == 2)
        makeCoarser(level, z, second_, coarser_[level]);
      else
        makeCoarser(level, z, coarser_[level - 1], coarser_[level]);
    }
  }

  template <class Sum, class Square, class Out>
  void makeCoarser(size_t level, int64_t z, const Planes<Sum, Square>& finer,
                   const Planes<Out, Out>& coarser) {
    const Vec3i step = levels_[level].step / levels_[level - 1].step;
    const Vec3i finer_size = sizes_[level - 1], size = sizes_[level];
    const Plane<Out, Out> to = coarser[static_cast<size_t>(z % 2)];
    const auto same = [](auto number) { return number; };
    for (int64_t y = 0; y < size.y; ++y) {
      const auto sums = rowsOf<Sum>(finer_size, step, y, z, [&](int64_t pz, int64_t py) {
        return finer[static_cast<size_t>(pz % 2)].sums + py * finer_size.x;
      });
      const auto squares = rowsOf<Square>(finer_size, step, y, z, [&](int64_t pz, int64_t py) {
        return finer[static_cast<size_t>(pz % 2)].squares + py * finer_size.x;
      });
      int64_t made = 0;
      if (level == 1 && std::is_same_v<T, uint8_t> && hasBlocksOf64(y, z)) made = made_of_64_;
      addRows<Sum>(sums, finer_size.x, step.x, same, to.sums + y * size.x, made);
      addRows<Square>(squares, finer_size.x, step.x, same, to.squares + y * size.x, made);
      finishRow<double>(level, y, z, to.sums + y * size.x, to.squares + y * size.x, made);
    }
  }

  // The rows of numbers below row y of plane z.
  template <class In, class RowAt>
  static FinerRows<In> rowsOf(Vec3i size, Vec3i step, int64_t y, int64_t z, RowAt rowAt) {
    FinerRows<In> rows;
    for (int64_t pz = z * step.z; pz < std::min((z + 1) * step.z, size.z); ++pz)
      for (int64_t py = y * step.y; py < std::min((y + 1) * step.y, size.y); ++py)
        rows.row[rows.count++] = rowAt(pz, py);
    return rows;
  }

  // The first `made` blocks are there already. Real: see finishBlocks().
  template <class Real, class Sum, class Square>
  void finishRow(size_t level, int64_t y, int64_t z, const Sum* sums, const Square* squares,
                 int64_t made = 0) {
    const LevelPart& part = levels_[level];
    const Vec3i step = part.step;
    const int64_t at = z * part.plane_stride + y * part.row_stride;
    T* const means = reinterpret_cast<T*>(part.voxels) + at;
    auto* const spreads = reinterpret_cast<SpreadOf<T>*>(part.spreads) + at;
    const int64_t rows = (std::min((y + 1) * step.y, cube_.size.y) - y * step.y) *
                         (std::min((z + 1) * step.z, cube_.size.z) - z * step.z);
    int64_t x = made;
    // Other counts, of blocks at the ends of axes, are divided one by one below.
    if (const int64_t count = rows * step.x; std::has_single_bit(static_cast<uint64_t>(count))) {
      x = cube_.size.x / step.x;
      finishBlocks<Real, T>(sums + made, squares + made, x - made, count, means + made,
                            spreads + made);
    }
    for (; x < sizes_[level].x; ++x) {
      const int64_t columns = std::min((x + 1) * step.x, cube_.size.x) - x * step.x;
      const BlockSums block{static_cast<double>(sums[x]), static_cast<double>(squares[x]),
                            static_cast<uint32_t>(rows * columns)};
      means[x] = voxelOf<T>(meanOf(block.value, block.count), block.count);
      spreads[x] = spreadOf<SpreadOf<T>>(block, 0);
    }
  }

  const CubeVoxels<T> cube_;
  const std::span<const LevelPart> levels_;
  std::vector<Vec3i> sizes_;  // blocks of each level
  Planes<int32_t, FirstSquare<T>> first_;
  Planes<SecondNumber<T>, SecondNumber<T>> second_;
  std::vector<Planes<double, double>> coarser_;  // of each level but the first two
  // Blocks of rows that makeTwoLevels() has made, the same of all rows.
  int64_t made_of_64_ = 0;
};

}  // namespace

template <class T>
void narrowMeans(const CubeVoxels<T>& cube, std::span<const LevelPart> levels,
                 std::vector<std::byte>& room) {
  if (levels.empty()) return;
  Pass<T> pass(cube, levels, room);
  inWideVectors([&pass] { pass.run(); });
}
template void narrowMeans(const CubeVoxels<uint8_t>&, std::span<const LevelPart>,
                          std::vector<std::byte>&);
template void narrowMeans(const CubeVoxels<int8_t>&, std::span<const LevelPart>,
                          std::vector<std::byte>&);
template void narrowMeans(const CubeVoxels<uint16_t>&, std::span<const LevelPart>,
                          std::vector<std::byte>&);
template void narrowMeans(const CubeVoxels<int16_t>&, std::span<const LevelPart>,
                          std::vector<std::byte>&);

uint64_t narrowMeansRoom(Vec3i size, std::span<const Vec3i> steps) {
  uint64_t numbers = 0;  // two planes a level, of two numbers of at most 8 bytes
  for (const Vec3i step : steps) {
    const Vec3i blocks = blocksOf(size, step);
    numbers += 4 * static_cast<uint64_t>(blocks.x * blocks.y);
  }
  return numbers * sizeof(double);
}

}  // namespace sluice
