// A part of a volume's voxels, evenly spread.
#include "src/library/opening/levels/volume_sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "src/base/sources/read_units.h"
#include "tests/support/counting_source.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

double valueAt(Vec3i v) {
  return static_cast<double>(v.x + 300 * v.y + 90000 * v.z);
}

// A source whose chunks can only be read whole.
class ChunkedFunction final : public FunctionSource, public UnitSource {
 public:
  ChunkedFunction(Vec3i dims, Vec3i chunk)
      : FunctionSource(functionLayout(dims, VoxelType::kF64),
                       [](int64_t, Vec3i v) { return valueAt(v); }),
        chunk_(chunk) {}
  ReadUnits readUnits() const override { return {.voxels = chunk_}; }

 private:
  const Vec3i chunk_;
};

VolumeSample sampleOf(VolumeSource& source, double seconds, uint64_t memory_bytes = UINT64_MAX) {
  WorkerPool pool(2);
  return sampleVolume({source, 0, pool, memory_bytes, seconds});
}

double voxelOfSample(const VolumeSample& sample, Vec3i v) {
  double value = 0;
  const auto at = static_cast<size_t>((v.z * sample.dims.y + v.y) * sample.dims.x + v.x);
  std::memcpy(&value, sample.voxels.data() + at * sizeof value, sizeof value);
  return value;
}

Vec3i placeOf(const VolumeSample& sample, Vec3i v) {
  const Vec3d at = sample.placement.finestFromLevel(toDouble(v));
  return {std::llround(at.x), std::llround(at.y), std::llround(at.z)};
}

template <class Body>
void eachVoxelOf(Vec3i dims, const Body& body) {
  for (int64_t z = 0; z < dims.z; ++z)
    for (int64_t y = 0; y < dims.y; ++y)
      for (int64_t x = 0; x < dims.x; ++x) body(Vec3i{x, y, z});
}

TEST(VolumeSample, voxelsAreThoseOfTheirPlaces) {
  for (const Vec3i dims : {Vec3i{40, 37, 130}, Vec3i{1100, 700, 40}, Vec3i{5, 4, 9}})
    for (const double seconds : {0.0, 1000.0}) {
      FunctionSource source(functionLayout(dims, VoxelType::kF64),
                            [](int64_t, Vec3i v) { return valueAt(v); });
      const VolumeSample sample = sampleOf(source, seconds);
      int wrong = 0;
      eachVoxelOf(sample.dims, [&](Vec3i v) {
        const Vec3i place = placeOf(sample, v);
        ASSERT_TRUE(boxOf(dims).contains({place, place + Vec3i{1, 1, 1}}));
        wrong += voxelOfSample(sample, v) == valueAt(place) ? 0 : 1;
      });
      EXPECT_EQ(wrong, 0);
      // No voxel is more than a step from the volume's upper end.
      for (int a = 0; a < 3; ++a)
        EXPECT_GT(static_cast<double>(placeOf(sample, sample.dims)[a]),
                  static_cast<double>(dims[a] - 1));
    }
}

TEST(VolumeSample, timeReadsEverySliceOfTheGrid) {
  FunctionSource source(functionLayout({40, 37, 130}, VoxelType::kF64),
                        [](int64_t, Vec3i v) { return valueAt(v); });
  EXPECT_EQ(sampleOf(source, 0).dims.z, 17);
  EXPECT_EQ(sampleOf(source, 0).part, "17 of 130 slices");
  EXPECT_EQ(sampleOf(source, 1000).dims.z, 65) << "a level is coarser than the volume";
}

TEST(VolumeSample, memoryBoundsIt) {
  FunctionSource source(functionLayout({200, 200, 200}, VoxelType::kF64),
                        [](int64_t, Vec3i v) { return valueAt(v); });
  const uint64_t memory = uint64_t{2} << 20;
  const VolumeSample sample = sampleOf(source, 1000, memory);
  EXPECT_LE(sample.voxels.size(), memory / 8);
  EXPECT_GT(sample.voxels.size(), memory / 80);
}

TEST(VolumeSample, betweenChunksTheNearestVoxelThatWasReadStands) {
  const Vec3i dims{130, 120, 140}, chunk{8, 8, 8};
  ChunkedFunction chunked(dims, chunk);
  const VolumeSample sample = sampleOf(chunked, 0);
  EXPECT_EQ(sample.part, "100 of 4590 chunks");
  const Vec3i scale{std::llround(sample.placement.scale.x), std::llround(sample.placement.scale.y),
                    std::llround(sample.placement.scale.z)};
  const int64_t distance = 4 * chunk.x;
  int exact = 0;
  eachVoxelOf(sample.dims, [&](Vec3i v) {
    const Vec3i place = placeOf(sample, v);
    const double value = voxelOfSample(sample, v);
    // The value names the voxel that it comes from.
    const auto number = static_cast<int64_t>(value);
    const Vec3i from{number % 300, number / 300 % 300, number / 90000};
    for (int a = 0; a < 3; ++a) {
      ASSERT_LT(from[a] % distance, chunk[a]) << "read";
      ASSERT_LE(std::abs(from[a] - place[a]), distance - chunk[a] / 2 + scale[a]) << "near";
      if (place[a] % distance < chunk[a]) {
        ASSERT_EQ(from[a], place[a]) << "its own";
      }
    }
    exact += from == place ? 1 : 0;
  });
  EXPECT_GT(exact, 0);
}

TEST(VolumeSample, rowsThatLieFarApartAreReadAlone) {
  // Rows of 80 KB, of which every 16th or so is on the grid.
  FunctionSource source(functionLayout({10000, 600, 20}, VoxelType::kF64),
                        [](int64_t, Vec3i v) { return valueAt(v); });
  CountingSource counted(source);
  const VolumeSample sample = sampleOf(counted, 1000);
  const auto read = static_cast<uint64_t>(counted.counts().bytes);
  const auto rows = static_cast<uint64_t>(sample.dims.y * sample.dims.z);
  EXPECT_EQ(read, rows * 10000 * sizeof(double));
}

TEST(VolumeSample, isWorthItWhereAPassTakesLonger) {
  VolumeLayout layout;
  layout.dims = {1024, 1024, 1024};
  EXPECT_TRUE(isWorthSampling(layout, 1));
  EXPECT_FALSE(isWorthSampling(layout, 10));
  layout.dims.z = 3;
  EXPECT_FALSE(isWorthSampling(layout, 0)) << "too thin for a level";
}

}  // namespace
}  // namespace sluice
