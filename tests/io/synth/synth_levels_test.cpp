#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "src/base/error.h"
#include "src/base/sources/volume_levels.h"
#include "tests/io/synth/synth_voxels.h"

namespace sluice {
namespace {

TEST(SynthSource, levelsAreMeansAndSpreadsOfTheVoxelsBelowRoundedOnce) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
    SynthOptions options = small(SynthKind::kNoise);
    options.type = type;
    options.dims = {39, 22, 17};
    options.levels = 3;
    const auto source = openSynth(options);
    const auto levels = coarserLevels(*source);
    ASSERT_EQ(levels.size(), 2U);
    EXPECT_EQ(source->layout().levels, 3);
    visitVoxelType(type, [&](auto tag) {
      using T = decltype(tag);
      const auto finest = readBox<T>(*source, boxOf(options.dims));
      for (size_t level = 0; level < 2; ++level) {
        const int64_t times = level == 0 ? 2 : 4;
        const Vec3i dims = options.dims / times;
        const VolumeLayout& layout = levels[level].source->layout();
        ASSERT_EQ(layout.dims, dims);
        EXPECT_EQ(layout.spacing, (Vec3d{1, 1, 1} * static_cast<double>(times)));
        EXPECT_EQ(levels[level].placement.finestFromLevel({1, 0, 0}).x, times + (times - 1) / 2.0);
        const Box3 part{{1, 2, 0}, dims};
        const auto voxels = readBox<T>(*levels[level].source, part);
        ASSERT_NE(levels[level].spreads, nullptr);
        ASSERT_EQ(levels[level].spreads->layout().type, type);
        const auto spreads = readBox<T>(*levels[level].spreads, part);
        size_t at = 0;
        for (int64_t z = part.lo.z; z < part.hi.z; ++z)
          for (int64_t y = part.lo.y; y < part.hi.y; ++y)
            for (int64_t x = part.lo.x; x < part.hi.x; ++x) {
              const int64_t count = times * times * times;
              const auto valueAt = [&](int64_t i) {
                const Vec3i v = Vec3i{x, y, z} * times +
                                Vec3i{i % times, i / times % times, i / (times * times)};
                return static_cast<double>(
                    finest[static_cast<size_t>((v.z * 22 + v.y) * 39 + v.x)]);
              };
              double mean = 0, variance = 0;
              for (int64_t i = 0; i < count; ++i) mean += valueAt(i) / static_cast<double>(count);
              for (int64_t i = 0; i < count; ++i)
                variance += std::pow(valueAt(i) - mean, 2) / static_cast<double>(count);
              const double rounding = type == VoxelType::kF32 ? 1e-6 : 0.5 + 1e-6;
              ASSERT_NEAR(static_cast<double>(spreads[at]), 2 * std::sqrt(variance), rounding);
              ASSERT_NEAR(static_cast<double>(voxels[at++]), mean, rounding);
            }
      }
    });
  }
}

TEST(SynthSource, levelsLeaveTheVoxelsAndTheirIdentityAlone) {
  SynthOptions options = small(SynthKind::kPhantom);
  const auto plain = openSynth(options);
  EXPECT_TRUE(coarserLevels(*plain).empty());
  options.levels = 4;
  const auto leveled = openSynth(options);
  EXPECT_EQ(leveled->identity(), plain->identity());
  std::set<std::string> identities{leveled->identity()};
  for (const CoarserLevel& level : coarserLevels(*leveled))
    for (const VolumeSource* source : {level.source, level.spreads})
      EXPECT_TRUE(identities.insert(source->identity()).second);
  EXPECT_EQ(parseSynthSpec(specOf(options)).levels, 4);
}

TEST(SynthSource, levelsOfTooFewVoxelsAreRefused) {
  EXPECT_THAT([] { openSynth(parseSynthSpec("synth:cube,dims=64x64x9,levels=4")); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("9 voxels have 3 levels")));
  EXPECT_THROW(parseSynthSpec("synth:cube,levels=0"), Error);
  EXPECT_THROW(parseSynthSpec("synth:cube,levels=x"), Error);
}

}  // namespace
}  // namespace sluice
