// The same of public volumes: no block is culled that a ray reaches.
#include <gtest/gtest.h>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/culling_scene.h"
#include "tests/render/real_volumes.h"

namespace sluice {
namespace {

struct Volume {
  const char* name;  // among realVolumes(), of bytes
  double threshold;
};
void PrintTo(const Volume& volume, std::ostream* out) {
  *out << volume.name;
}

class CullingData : public testing::TestWithParam<Volume> {};

TEST_P(CullingData, noBlockIsCulledThatRaysReach) {
  const auto known = std::ranges::find_if(realVolumes(), [](const RealVolume& volume) {
    return std::string_view(volume.name) == GetParam().name;
  });
  ASSERT_NE(known, realVolumes().end());
  const auto file = openReal(*known);
  if (file == nullptr) GTEST_SKIP() << known->input << " is not there";
  VolumeLayout layout = file->layout();
  ASSERT_EQ(layout.type, VoxelType::kU8);
  std::vector<std::byte> voxels(static_cast<size_t>(volume(layout.dims)));
  file->readRegion(0, boxOf(layout.dims), voxels);
  layout.time_steps = 1;
  MemorySource source(layout, std::move(voxels));

  std::mt19937 random(7);
  ReachedCounts counts;
  for (const double opacity : {1.0, 0.2}) {
    CullingScene scene(source, thresholdTransfer(GetParam().threshold, {0, 255}, opacity, "grey"),
                       16);
    const TestSeries series = makeTestSeries(source, scene.ranges->layout, scene.look->table);
    for (int i = 0; i < 12; ++i) {
      SCOPED_TRACE(testing::Message() << "opacity " << opacity << " view " << i);
      expectNothingReachedIsCulled(scene, series, randomView(random, layout),
                                   i % 2 == 0 ? 0.95 : 254.0 / 255, counts);
    }
  }
  EXPECT_LT(counts.visible, counts.nonempty) << "else nothing is tested";
}

INSTANTIATE_TEST_SUITE_P(Data, CullingData,
                         testing::Values(Volume{"bonsai", 40}, Volume{"engine_raw", 80},
                                         Volume{"head_mr", 60}, Volume{"visible_female_head", 60}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sluice
