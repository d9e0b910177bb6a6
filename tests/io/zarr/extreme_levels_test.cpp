// Levels of maxima and minima against plain loops over the voxels of each block.
#include "io/zarr/levels/extreme_levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace sluice {
namespace {

// A voxel of a level by definition: NaN only if the block has nothing else.
template <class T>
T extremeOfBlock(const CubeVoxels<T>& cube, Vec3i lo, Vec3i hi, bool greatest) {
  T extreme{};
  bool is_any = false;
  for (int64_t z = lo.z; z < hi.z; ++z)
    for (int64_t y = lo.y; y < hi.y; ++y)
      for (int64_t x = lo.x; x < hi.x; ++x) {
        const T value = cube.voxels[z * cube.plane_stride + y * cube.row_stride + x];
        if (std::isnan(static_cast<double>(value))) continue;
        if (!is_any || (greatest ? value > extreme : value < extreme)) extreme = value;
        is_any = true;
      }
  if constexpr (std::is_floating_point_v<T>)
    if (!is_any) return std::numeric_limits<T>::quiet_NaN();
  return extreme;
}

template <class T>
bool isSame(T a, T b) {
  return a == b || (std::isnan(static_cast<double>(a)) && std::isnan(static_cast<double>(b)));
}

template <class T>
void expectExtremes(Vec3i size, const std::vector<Vec3i>& steps, double nan_share = 0) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(std::is_signed_v<T> ? -100 : 0, 100);
  std::bernoulli_distribution is_nan(nan_share);
  // Rows that lie apart.
  const Vec3i stored = size + Vec3i{3, 2, 0};
  std::vector<T> voxels(static_cast<size_t>(volume(stored)));
  for (T& voxel : voxels) {
    voxel = static_cast<T>(value(random));
    if constexpr (std::is_floating_point_v<T>)
      if (is_nan(random)) voxel = std::numeric_limits<T>::quiet_NaN();
  }
  const CubeVoxels<T> cube{size, voxels.data(), stored.x, stored.x * stored.y};
  for (const bool greatest : {true, false}) {
    std::vector<std::vector<T>> made;
    std::vector<LevelPart> parts;
    for (const Vec3i& step : steps) {
      const Vec3i level = blocksOf(size, step);
      made.emplace_back(static_cast<size_t>(volume(level)), T{123});
      parts.push_back({step, nullptr, nullptr, level.x, level.x * level.y});
    }
    for (size_t i = 0; i < parts.size(); ++i)
      parts[i].voxels = reinterpret_cast<std::byte*>(made[i].data());
    extremeLevels(cube, parts, greatest ? Downsample::kMax : Downsample::kMin);
    for (size_t i = 0; i < steps.size(); ++i) {
      const Vec3i level = blocksOf(size, steps[i]);
      size_t wrong = 0, at = 0;
      for (int64_t z = 0; z < level.z; ++z)
        for (int64_t y = 0; y < level.y; ++y)
          for (int64_t x = 0; x < level.x; ++x, ++at) {
            const Vec3i lo = Vec3i{x, y, z} * steps[i], hi = min(lo + steps[i], size);
            wrong += isSame(made[i][at], extremeOfBlock(cube, lo, hi, greatest)) ? 0 : 1;
          }
      EXPECT_EQ(wrong, 0U) << "level " << i + 1 << " of " << size.x << " columns";
    }
  }
}

TEST(ExtremeLevels, areThoseOfTheVoxelsOfEachBlock) {
  for (const auto& steps : {std::vector<Vec3i>{{2, 2, 2}, {4, 4, 4}, {8, 8, 8}},
                            {{1, 2, 2}, {2, 4, 4}},
                            {{2, 1, 1}, {2, 2, 1}, {4, 4, 2}}})
    for (const int64_t columns : {1, 2, 7, 64, 511, 512, 513, 1300}) {
      expectExtremes<uint8_t>({columns, 9, 7}, steps);
      expectExtremes<int16_t>({columns, 8, 5}, steps);
      expectExtremes<float>({columns, 5, 9}, steps);
    }
  expectExtremes<int8_t>({33, 31, 1}, {{2, 2, 1}, {4, 4, 1}});
  expectExtremes<uint16_t>({65, 1, 17}, {{2, 1, 2}});
  expectExtremes<int32_t>({20, 20, 20}, {{2, 2, 2}});
  expectExtremes<double>({20, 20, 20}, {{2, 2, 2}});
}

TEST(ExtremeLevels, nanCountsOnlyInBlocksThatHaveNothingElse) {
  for (const double share : {0.2, 0.9, 1.0}) {
    expectExtremes<float>({530, 9, 7}, {{2, 2, 2}, {4, 4, 4}}, share);
    expectExtremes<double>({21, 20, 19}, {{1, 2, 2}, {2, 4, 4}}, share);
  }
}

}  // namespace
}  // namespace sluice
