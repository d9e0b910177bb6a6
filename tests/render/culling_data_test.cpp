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

// Null if it is not there.
std::unique_ptr<VolumeSource> openNamed(std::string_view name) {
  const auto known = std::ranges::find_if(
      realVolumes(), [&](const RealVolume& volume) { return volume.name == name; });
  return openReal(*known);
}

TEST_P(CullingData, noBlockIsCulledThatRaysReach) {
  const auto file = openNamed(GetParam().name);
  if (file == nullptr) GTEST_SKIP() << GetParam().name << " is not there";
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

TEST(CullingSeries, noBlockOfViscousFingersIsCulledThatRaysReach) {
  const auto file = openNamed("viscous_fingers");
  if (file == nullptr) GTEST_SKIP() << "viscous-fingers is not there";
  VolumeLayout layout = file->layout();
  ASSERT_EQ(layout.type, VoxelType::kF32);
  constexpr std::array<int64_t, 5> kSteps{1, 2, 12, 25, 39};
  const size_t step_bytes = static_cast<size_t>(volume(layout.dims)) * sizeof(float);
  std::vector<std::byte> voxels(kSteps.size() * step_bytes);
  for (size_t i = 0; i < kSteps.size(); ++i)
    file->readRegion(kSteps[i], boxOf(layout.dims),
                     std::span(voxels).subspan(i * step_bytes, step_bytes));
  layout.time_steps = static_cast<int64_t>(kSteps.size());
  MemorySource source(layout, std::move(voxels));

  std::mt19937 random(11);
  ReachedCounts counts;
  for (const double opacity : {1.0, 0.2}) {
    const TransferFunction transfer = thresholdTransfer(5, {0, 100}, opacity, "grey");
    const CullingScene first(source, transfer, 8);
    // Fused functions, and the functions of each step.
    for (const double difference : {0.0, 1e-3}) {
      SeriesPassOptions pass;
      pass.difference = difference;
      const TestSeries series =
          makeTestSeries(source, first.ranges->layout, first.look->table, pass);
      for (int64_t time = 0; time < layout.time_steps; ++time) {
        CullingScene scene(source, transfer, 8, time);
        for (int i = 0; i < 8; ++i) {
          SCOPED_TRACE(testing::Message() << "opacity " << opacity << " difference " << difference
                                          << " step " << time << " view " << i);
          expectNothingReachedIsCulled(scene, series, randomView(random, layout),
                                       i % 2 == 0 ? 0.95 : 254.0 / 255, counts);
        }
      }
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
