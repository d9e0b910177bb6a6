// OpenVDB's samples and files that its tools make, against what these tools say of them.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/vdb/vdb_source.h"
#include "tests/io/image_test_support.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(VdbPeers, agreesWithVdbPrintOnTheSmokeSample) {
  const std::string path = SLUICE_DATA_DIR "/smoke.vdb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  if (!haveProgram("vdb_print")) GTEST_SKIP() << "vdb_print is missing";
  const std::string printed = runCommand("vdb_print -l " + path).output;
  ASSERT_THAT(printed, HasSubstr("Dimensions of active voxels:   111 x 222 x 112"));
  ASSERT_THAT(printed, AllOf(HasSubstr("Min value: 1.00136e-05"), HasSubstr("Max value: 5.71484")));
  ASSERT_THAT(printed, HasSubstr("Number of active voxels:       1,049,275"));
  const auto source = openVdb(path);
  EXPECT_EQ(source->layout().dims, (Vec3i{113, 224, 114}));
  EXPECT_EQ(source->layout().name, "density");
  const auto values = valuesOf<float>(readAll(*source));
  float least = 100, most = 0;
  int64_t above_zero = 0;
  for (const float value : values) {
    most = std::max(most, value);
    if (value > 0) least = std::min(least, value);
    above_zero += value > 0 ? 1 : 0;
  }
  EXPECT_NEAR(least, 1.00136e-05, 1e-10);
  EXPECT_NEAR(most, 5.71484, 1e-5);
  EXPECT_EQ(above_zero, 1'049'275);
}

TEST(VdbPeers, opensTheLevelSetSamples) {
  for (const auto& [file, side] : {std::pair{"cube", 227}, std::pair{"sphere", 127}}) {
    const std::string path = fmt::format("{}/{}.vdb", SLUICE_DATA_DIR, file);
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
    const auto source = openVdb(path);
    EXPECT_EQ(source->layout().dims, (Vec3i{side, side, side}));
    EXPECT_EQ(source->layout().name, fmt::format("ls_{} (level set)", file));
    EXPECT_NEAR(source->layout().spacing.x, 0.05, 1e-7);
    EXPECT_NEAR(source->occupancy(0)->background, 0.150024, 1e-5);
    EXPECT_NEAR(valueAt<float>(*source, {side / 2, side / 2, side / 2}), -0.150024, 1e-5);
    EXPECT_NEAR(valueAt<float>(*source, {0, 0, 0}), 0.150024, 1e-5);
  }
}

TEST(VdbPeers, deliversTheDistancesOfASphereMadeByVdbTool) {
  if (!haveProgram("vdb_tool")) GTEST_SKIP() << "vdb_tool is missing";
  const TempFolder folder;
  const std::string file = (folder / "sphere.vdb").string();
  ASSERT_EQ(runCommand("vdb_tool -quiet -sphere dim=64 radius=1 -write " + file).status, 0);
  const auto source = openVdb(file);
  const VolumeLayout& layout = source->layout();
  const double width = source->occupancy(0)->background;
  ASSERT_GT(width, 0);
  const auto values = valuesOf<float>(readAll(*source));
  double largest_difference = 0;
  size_t n = 0;
  for (int64_t z = 0; z < layout.dims.z; ++z)
    for (int64_t y = 0; y < layout.dims.y; ++y)
      for (int64_t x = 0; x < layout.dims.x; ++x, ++n) {
        const Vec3d at = layout.origin + layout.spacing * toDouble({x, y, z});
        const double distance = std::clamp(length(at) - 1, -width, width);
        largest_difference = std::max(largest_difference, std::abs(values[n] - distance));
      }
  EXPECT_LT(largest_difference, 1e-5);
}

TEST(VdbPeers, deliversFogMadeByVdbTool) {
  if (!haveProgram("vdb_tool")) GTEST_SKIP() << "vdb_tool is missing";
  const TempFolder folder;
  const std::string file = (folder / "fog.vdb").string();
  ASSERT_EQ(runCommand("vdb_tool -quiet -sphere dim=64 radius=1 -ls2fog -write " + file).status, 0);
  const auto source = openVdb(file);
  const Vec3i middle = source->layout().dims / Vec3i{2, 2, 2};
  EXPECT_EQ(valueAt<float>(*source, middle), 1.0F);  // an active tile
  EXPECT_EQ(valueAt<float>(*source, {0, 0, 0}), 0.0F);
  EXPECT_EQ(source->occupancy(0)->background, 0);
}

}  // namespace
}  // namespace sluice
