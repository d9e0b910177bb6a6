#include "io/vdb/vdb_series.h"

#include <gmock/gmock.h>

#include "io/open_volume.h"
#include "tests/io/image_test_support.h"
#include "tests/support/vdb_writer.h"

namespace sluice {
namespace {

using testing::HasSubstr;

std::vector<std::string> namesIn(const TempFolder& folder, int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back((folder / fmt::format("s{}.vdb", i)).string());
  return names;
}

// A plume that grows upwards, with nothing in its first step.
TEST(VdbSeries, stepsOfDifferentBoxesFillTheBoxAroundAll) {
  const TempFolder folder;
  const auto names = namesIn(folder, 4);
  writePoints(names[0], {});
  writePoints(names[1], {{{10, 0, 10}, 1.0F}});
  writePoints(names[2], {{{9, 0, 10}, 2.0F}, {{11, 5, 10}, 3.0F}});
  writePoints(names[3], {{{10, 20, 12}, 4.0F}});
  const auto source = openVolume(names);
  const VolumeLayout& layout = source->layout();
  EXPECT_EQ(layout.time_steps, 4);
  EXPECT_EQ(layout.dims, (Vec3i{5, 23, 5}));
  EXPECT_EQ(layout.origin, (Vec3d{8, -1, 9}));
  for (int64_t t = 0; t < 4; ++t) {
    const auto values = valuesOf<float>(readAll(*source, t));
    std::map<std::array<int64_t, 3>, float> found;
    for (int64_t z = 0, n = 0; z < 5; ++z)
      for (int64_t y = 0; y < 23; ++y)
        for (int64_t x = 0; x < 5; ++x, ++n)
          if (values[static_cast<size_t>(n)] != 0)
            found[{x + 8, y - 1, z + 9}] = values[static_cast<size_t>(n)];
    const std::vector<std::map<std::array<int64_t, 3>, float>> expected = {
        {},
        {{{10, 0, 10}, 1.0F}},
        {{{9, 0, 10}, 2.0F}, {{11, 5, 10}, 3.0F}},
        {{{10, 20, 12}, 4.0F}}};
    EXPECT_EQ(found, expected[static_cast<size_t>(t)]) << t;
    const auto occupancy = source->occupancy(t);
    ASSERT_TRUE(occupancy.has_value());
    for (const Box3& box : occupancy->boxes) EXPECT_TRUE(boxOf(layout.dims).contains(box));
  }
}

// The voxels of one step are numbered from another origin than the other's.
TEST(VdbSeries, transformsMayDifferByWholeVoxels) {
  const TempFolder folder;
  const auto names = namesIn(folder, 2);
  // writeTransformed() sets voxel (3, 4, 5).
  writeTransformed(names[0], {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0, 0, 0}});
  writeTransformed(names[1], {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {8, 0, 0}});
  const auto source = openVolume(names);
  EXPECT_EQ(source->layout().dims, (Vec3i{7, 3, 3}));
  EXPECT_EQ(source->layout().origin, (Vec3d{4, 6, 8}));
  for (const int64_t t : {0, 1}) {
    const auto values = valuesOf<float>(readBox(*source, {{0, 1, 1}, {7, 2, 2}}, t));
    for (int64_t x = 0; x < 7; ++x)
      EXPECT_EQ(values[static_cast<size_t>(x)], x == 1 + 4 * t ? 1 : 0) << t << " " << x;
  }
}

TEST(VdbSeries, transformsThatDifferOtherwiseAreRefused) {
  const TempFolder folder;
  const auto names = namesIn(folder, 2);
  writeTransformed(names[0], {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0, 0, 0}});
  writeTransformed(names[1], {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0}});
  EXPECT_THAT(errorOf([&] { openVolume(names); }), HasSubstr("s1.vdb: its voxels lie between"));
  writeTransformed(names[1], {{1, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0, 0, 0}});
  EXPECT_THAT(errorOf([&] { openVolume(names); }), HasSubstr("another size"));
  writePoints(names[0], {});
  writePoints(names[1], {});
  EXPECT_THAT(errorOf([&] { openVolume(names); }), HasSubstr("no active voxels in any of the 2"));
}

}  // namespace
}  // namespace sluice
