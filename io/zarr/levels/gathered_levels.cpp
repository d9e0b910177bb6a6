#include "io/zarr/levels/gathered_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

void gather(BlockSums& block, const BlockSums& more) {
  if (more.count == 0) return;
  block.value += more.value;
  block.squares += more.squares;
  block.count += more.count;
}

// The number that stands most often in `values`, and how often. The values are put in order.
template <class T>
struct ModeCount {
  T mode{};
  size_t count = 0;
};
template <class T>
ModeCount<T> modeOf(std::vector<T>& values) {
  if (values.empty()) {
    // A block of NaN alone stays NaN.
    if constexpr (std::is_floating_point_v<T>) return {std::numeric_limits<T>::quiet_NaN(), 0};
    return {};
  }
  std::sort(values.begin(), values.end());
  T mode = values.front();
  size_t most = 0;
  for (size_t i = 0; i < values.size();) {
    size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    // The smallest of values that are equally often wins, so that results do not hang on the
    // order.
    if (end - i > most) {
      most = end - i;
      mode = values[i];
    }
    i = end;
  }
  return {mode, most};
}

// The share of the values that are not the mode, as a number of its type.
template <class Share>
Share shareOf(size_t others, size_t all) {
  if (others == 0) return 0;
  const double share = static_cast<double>(others) / static_cast<double>(all);
  if constexpr (std::is_floating_point_v<Share>)
    return static_cast<Share>(share);
  else
    return static_cast<Share>(rounded(share * std::numeric_limits<Share>::max()));
}

template <class F>
void eachVoxel(Vec3i size, F&& f) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y)
      for (int64_t x = 0; x < size.x; ++x) f(Vec3i{x, y, z});
}

template <class T>
bool isNumber(T value) {
  if constexpr (std::is_floating_point_v<T>) return !std::isnan(value);
  return true;
}

// Squares of a cube are measured from this value: its first voxel's, or 0.
template <class T>
double originOf(const T* voxels) {
  if constexpr (kIsNarrow<T>) return 0;  // sums are exact, whatever the cube
  // Squares of values far from 0 would cancel each other's digits in a variance.
  const auto value = static_cast<double>(*voxels);
  return std::isfinite(value) ? value : 0;
}

BlockSums* rowOf(std::vector<BlockSums>& blocks, Vec3i size, int64_t y, int64_t z) {
  return blocks.data() + (z * size.y + y) * size.x;
}

// A step from a level to the next is 1 or 2 along each axis, and so a shift of the index by 0 or 1.

// Blocks into those of the next level.
void gatherCoarser(std::vector<BlockSums>& finer, Vec3i finer_size, Vec3i step,
                   std::vector<BlockSums>& coarser, Vec3i size) {
  for (int64_t z = 0; z < finer_size.z; ++z)
    for (int64_t y = 0; y < finer_size.y; ++y) {
      const BlockSums* const from = rowOf(finer, finer_size, y, z);
      BlockSums* const to = rowOf(coarser, size, y >> (step.y - 1), z >> (step.z - 1));
      for (int64_t x = 0; x < finer_size.x; ++x) gather(to[x >> (step.x - 1)], from[x]);
    }
}

// The finest voxels of a cube into the blocks of the first level.
template <class T>
void gatherFirst(const CubeVoxels<T>& cube, Vec3i step, double origin,
                 std::vector<BlockSums>& blocks, Vec3i size) {
  for (int64_t z = 0; z < cube.size.z; ++z)
    for (int64_t y = 0; y < cube.size.y; ++y) {
      BlockSums* const row = rowOf(blocks, size, y >> (step.y - 1), z >> (step.z - 1));
      const T* const from = cube.voxels + z * cube.plane_stride + y * cube.row_stride;
      for (int64_t x = 0; x < cube.size.x; ++x)
        if (isNumber(from[x])) {
          const auto value = static_cast<double>(from[x]);
          const double away = value - origin;
          gather(row[x >> (step.x - 1)], {value, away * away, 1});
        }
    }
}

template <class T>
void putModes(const CubeVoxels<T>& cube, const LevelPart& part) {
  std::vector<T> values;
  eachVoxel(blocksOf(cube.size, part.step), [&](Vec3i p) {
    const Vec3i lo = p * part.step, hi = min(lo + part.step, cube.size);
    values.clear();
    eachVoxel(hi - lo, [&](Vec3i q) {
      const Vec3i at = lo + q;
      const T value = cube.voxels[at.z * cube.plane_stride + at.y * cube.row_stride + at.x];
      if (isNumber(value)) values.push_back(value);
    });
    const int64_t at = p.z * part.plane_stride + p.y * part.row_stride + p.x;
    const ModeCount<T> found = modeOf(values);
    reinterpret_cast<T*>(part.voxels)[at] = found.mode;
    if (part.spreads != nullptr)
      reinterpret_cast<SpreadOf<T>*>(part.spreads)[at] =
          shareOf<SpreadOf<T>>(values.size() - found.count, values.size());
  });
}

template <class T>
void put(std::vector<BlockSums>& blocks, Vec3i size, double origin, const LevelPart& part) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const BlockSums* const row = rowOf(blocks, size, y, z);
      const int64_t at = z * part.plane_stride + y * part.row_stride;
      T* const to = reinterpret_cast<T*>(part.voxels) + at;
      for (int64_t x = 0; x < size.x; ++x)
        to[x] = voxelOf<T>(meanOf(row[x].value, row[x].count), row[x].count);
      auto* const spreads = reinterpret_cast<SpreadOf<T>*>(part.spreads) + at;
      for (int64_t x = 0; x < size.x; ++x) spreads[x] = spreadOf<SpreadOf<T>>(row[x], origin);
    }
}

}  // namespace

template <class T>
void gatheredLevels(const CubeVoxels<T>& cube, std::span<const LevelPart> levels, Downsample how,
                    GatheredRoom& room) {
  SLUICE_CHECK(how == Downsample::kMean || how == Downsample::kMode);
  const double origin = originOf(cube.voxels);
  Vec3i finer_step{1, 1, 1}, finer_size;
  for (const LevelPart& part : levels) {
    if (how == Downsample::kMode) {
      // The mode of modes is not the mode: each level is made from the finest voxels.
      putModes(cube, part);
      continue;
    }
    // Gathered from the blocks of the level before, whose sums are not rounded.
    const Vec3i size = blocksOf(cube.size, part.step), step = part.step / finer_step;
    room.coarser.assign(static_cast<size_t>(volume(size)), BlockSums{});
    if (&part == levels.data())
      gatherFirst(cube, step, origin, room.coarser, size);
    else
      gatherCoarser(room.finer, finer_size, step, room.coarser, size);
    put<T>(room.coarser, size, origin, part);
    std::swap(room.finer, room.coarser);
    finer_step = part.step;
    finer_size = size;
  }
}

// The types of visitVoxelType().
template void gatheredLevels(const CubeVoxels<uint8_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<int8_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<uint16_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<int16_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<uint32_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<int32_t>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<float>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);
template void gatheredLevels(const CubeVoxels<double>&, std::span<const LevelPart>, Downsample,
                             GatheredRoom&);

}  // namespace sluice
