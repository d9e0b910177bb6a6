// Levels of narrow voxels with vector instructions, against sums in doubles, block by block.
#include "io/zarr/levels/narrow_means.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "io/zarr/levels/gathered_levels.h"

namespace sluice {
namespace {

template <class T>
struct MadeLevels {
  std::vector<std::vector<T>> means;
  std::vector<std::vector<SpreadOf<T>>> spreads;
};

template <class T, class Make>
MadeLevels<T> levelsBy(const CubeVoxels<T>& cube, const std::vector<Vec3i>& steps,
                       const Make& make) {
  MadeLevels<T> made;
  std::vector<LevelPart> parts;
  for (const Vec3i step : steps) {
    const Vec3i size = blocksOf(cube.size, step);
    made.means.emplace_back(static_cast<size_t>(volume(size)), T{77});
    made.spreads.emplace_back(static_cast<size_t>(volume(size)), SpreadOf<T>{77});
    parts.push_back({step, reinterpret_cast<std::byte*>(made.means.back().data()),
                     reinterpret_cast<std::byte*>(made.spreads.back().data()), size.x,
                     size.x * size.y});
  }
  make(std::span<const LevelPart>(parts));
  return made;
}

template <class T>
void expectSameLevels(Vec3i size, int64_t least, int64_t most, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int64_t> value(least, most);
  std::vector<T> voxels(static_cast<size_t>(volume(size)));
  for (T& voxel : voxels) voxel = static_cast<T>(value(random));
  const CubeVoxels<T> cube{size, voxels.data(), size.x, size.x * size.y};
  for (const std::vector<Vec3i>& steps :
       {std::vector<Vec3i>{
            {2, 2, 2}, {4, 4, 4}, {8, 8, 8}, {16, 16, 16}, {32, 32, 32}, {64, 64, 64}},
        {{2, 2, 1}, {4, 4, 2}}}) {
    std::vector<std::byte> room;
    const auto narrow = levelsBy(
        cube, steps, [&](std::span<const LevelPart> parts) { narrowMeans(cube, parts, room); });
    GatheredRoom gathered_room;
    const auto gathered = levelsBy(cube, steps, [&](std::span<const LevelPart> parts) {
      gatheredLevels(cube, parts, Downsample::kMean, gathered_room);
    });
    EXPECT_EQ(narrow.means, gathered.means) << size.x;
    EXPECT_EQ(narrow.spreads, gathered.spreads) << size.x;
  }
}

TEST(NarrowMeans, areThoseOfDoublesInRowsOfAnyLength) {
  for (const int64_t x : {2, 31, 32, 33, 64, 65, 95, 128, 200}) {
    expectSameLevels<uint8_t>({x, 9, 8}, 0, 255, 1);
    expectSameLevels<int8_t>({x, 8, 9}, -128, 127, 2);
    expectSameLevels<uint16_t>({x, 8, 8}, 0, 65535, 3);
    expectSameLevels<int16_t>({x, 8, 8}, -32768, 32767, 4);
  }
}

// Few values make every tie: means and spreads half way between two numbers.
TEST(NarrowMeans, roundTiesToTheEvenNumber) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    expectSameLevels<uint8_t>({128, 16, 8}, 0, 3, seed);
    expectSameLevels<uint16_t>({64, 16, 8}, 32766, 32769, seed);
    expectSameLevels<int16_t>({64, 16, 8}, -2, 1, seed);
  }
}

TEST(NarrowMeans, ofOneValueAreThatValue) {
  for (const int64_t value : {0, 1, 200, 255})
    expectSameLevels<uint8_t>({130, 10, 9}, value, value, 1);
}

// Sums and squares of a whole cube of the greatest values fit the numbers that hold them.
TEST(NarrowMeans, ofTheGreatestValuesAreExact) {
  expectSameLevels<uint8_t>({64, 64, 64}, 255, 255, 1);
  expectSameLevels<uint8_t>({64, 64, 64}, 254, 255, 2);
  expectSameLevels<int8_t>({64, 64, 64}, -128, -127, 3);
  expectSameLevels<uint16_t>({64, 64, 64}, 65534, 65535, 4);
  expectSameLevels<int16_t>({64, 64, 64}, -32768, -32767, 5);
}

TEST(NarrowMeans, holdTheGreatestSpread) {
  for (uint32_t seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    std::vector<uint8_t> voxels(size_t{64} * 4 * 4);
    for (uint8_t& voxel : voxels) voxel = random() % 2 == 0 ? 0 : 255;
    const CubeVoxels<uint8_t> cube{{64, 4, 4}, voxels.data(), 64, 256};
    const std::vector<Vec3i> steps{{2, 2, 2}, {4, 4, 4}};
    std::vector<std::byte> room;
    const auto narrow = levelsBy(
        cube, steps, [&](std::span<const LevelPart> parts) { narrowMeans(cube, parts, room); });
    GatheredRoom gathered_room;
    const auto gathered = levelsBy(cube, steps, [&](std::span<const LevelPart> parts) {
      gatheredLevels(cube, parts, Downsample::kMean, gathered_room);
    });
    EXPECT_EQ(narrow.means, gathered.means);
    EXPECT_EQ(narrow.spreads, gathered.spreads);
    EXPECT_EQ(*std::max_element(narrow.spreads[0].begin(), narrow.spreads[0].end()), 255);
  }
}

}  // namespace
}  // namespace sluice
