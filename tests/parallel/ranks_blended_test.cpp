// Pictures of blended channels by ranks that are threads: each has all channels of its blocks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/parallel/communication/in_process.h"
#include "src/parallel/compositing.h"
#include "src/parallel/part_device.h"
#include "src/parallel/rank_blocks.h"
#include "tests/device/suite_device.h"
#include "tests/render/blended_scene.h"
#include "tests/render/blob_scene.h"

namespace sluice {
namespace {

// The suite's device, which must not be asked for a picture: a part is drawn in one go.
class DeviceOfParts : public Device {
 public:
  DeviceLimits limits() const override { return device_->limits(); }
  const char* backend() const override { return device_->backend(); }
  const char* renderer() const override { return device_->renderer(); }
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override {
    device_->makeResident(id, std::move(texels));
  }
  void evict(uint64_t id) override { device_->evict(id); }
  uint64_t uploadedBytes() const override { return device_->uploadedBytes(); }
  uint64_t binds() const override { return device_->binds(); }
  void beginFrame(const FrameSetup& setup, const StopToken& stop) override {
    device_->beginFrame(setup, stop);
  }
  void draw(std::span<const BoxDraw> boxes) override { device_->draw(boxes); }
  std::vector<float> leastOpacity(const MapGrid& grid) override {
    return device_->leastOpacity(grid);
  }
  void stopOpaque() override { device_->stopOpaque(); }
  uint64_t countSamples(std::span<const BoxDraw> boxes) override {
    return device_->countSamples(boxes);
  }
  uint64_t takenSamples() override { return device_->takenSamples(); }
  Picture endFrame() override {
    ADD_FAILURE() << "a layer of a part is drawn as a picture";
    return device_->endFrame();
  }
  bool drawsParts() const override { return device_->drawsParts(); }
  PartialPicture endPart() override { return device_->endPart(); }
  void cancelFrame() override { device_->cancelFrame(); }

 private:
  const std::unique_ptr<Device> device_ = suiteDevice();
};

FloatPicture onRanks(int ranks, const std::vector<BlendedChannel>& channels,
                     const SceneOptions& scene_options, const FrameOptions& options,
                     uint64_t& taken) {
  FloatPicture result;
  std::atomic<uint64_t> samples = 0;
  const BlockLayout layout =
      blockLayout(kBlendedDims, scene_options.block_vox, scene_options.lit ? 1 : 0);
  const auto ends = runInProcess(ranks, [&](Team& team) {
    WorkerPool pool(1);
    const Dealing dealing = dealBlocks(layout, ranks);
    PartDevice device(std::make_unique<DeviceOfParts>(), dealing);
    std::vector<std::unique_ptr<RankBlocks>> mine;
    BlendedScene scene(device, channels, scene_options);
    for (Session* session : scene.sessions()) {
      mine.push_back(std::make_unique<RankBlocks>(dealing, team.rank(), pool));
      session->chooseBlocksBy(mine.back().get());
    }
    scene.setOptions(options);
    std::vector<FrameReport> reports;
    scene.draw(reports);
    samples += reports.front().samples_taken;
    CompositingReport report;
    Picture picture = composite(team, device.takePart(), device.setup(), pool, UINT64_MAX, report);
    if (team.isFirst())
      result = {picture.width, picture.height, std::move(picture.rgba), std::move(picture.depth)};
  });
  EXPECT_THAT(ends, testing::Each(std::string()));
  taken = samples;
  return result;
}

TEST(RanksBlended, drawThePictureOfOneProcessInOneGo) {
  const std::vector<BlendedChannel> channels = threeChannels();
  for (const Projection projection : kProjections)
    for (const bool lit : {false, true}) {
      SCOPED_TRACE(fmt::format("projection {} lit {}", static_cast<int>(projection), lit));
      FrameOptions options = obliqueView(projection);
      options.with_depth = !lit;
      options.count_samples = lit;
      options.skipping = Skipping::kShading;
      const SceneOptions scene_options{.block_vox = 8, .lit = lit};
      const std::unique_ptr<Device> device = suiteDevice();
      BlendedScene alone(*device, channels, scene_options);
      alone.setOptions(options);
      std::vector<FrameReport> reports;
      const FloatPicture whole = alone.draw(reports);
      EXPECT_GE(shownShare(whole), 0.05);
      for (const int ranks : {1, 2, 4, 7}) {
        SCOPED_TRACE(fmt::format("{} ranks", ranks));
        uint64_t taken = 0;
        EXPECT_TRUE(within(1, whole, onRanks(ranks, channels, scene_options, options, taken)));
        EXPECT_EQ(taken, reports.front().samples_taken);
      }
    }
}

}  // namespace
}  // namespace sluice
