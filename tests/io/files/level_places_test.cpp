// Finding the places of levels takes little memory; the places themselves are tests of the formats.
#include "io/files/level_places.h"

#include <gtest/gtest.h>

#include "tests/support/function_source.h"
#include "tests/support/memory_peak.h"

namespace sluice {
namespace {

// A function of the place in finest voxels whose means are its values at the middles.
double valueAt(Vec3d at) {
  return 3 * at.x + 5 * at.y + 7 * at.z;
}

// Levels of sixteen to one, at the largest distance between two levels that are compared.
TEST(LevelPlaces, takeLittleMemoryHoweverFarApartTheLevelsAre) {
  if (!MemoryPeak::works()) GTEST_SKIP() << "a sanitizer's allocator";
  constexpr int64_t kTimes = 16, kCoarse = 64;
  for (const VoxelOrigin origin : {VoxelOrigin::kCorner, VoxelOrigin::kCentre}) {
    const Vec3i dims{kCoarse, kCoarse, kCoarse};
    const Vec3d factor{kTimes, kTimes, kTimes};
    const Vec3d first = offsetOf(origin, factor);
    FunctionSource fine(functionLayout(dims * kTimes, VoxelType::kF32),
                        [](int64_t, Vec3i at) { return valueAt(toDouble(at)); });
    FunctionSource coarse(functionLayout(dims, VoxelType::kF32), [&](int64_t, Vec3i at) {
      return valueAt(first + factor * toDouble(at));
    });
    const MemoryPeak peak;
    EXPECT_EQ(originOf(fine, coarse, factor), origin);
    // All fine voxels of a cell at once took more than 90 MB.
    EXPECT_LT(peak.bytes(), 40 << 20);
  }
}

}  // namespace
}  // namespace sluice
