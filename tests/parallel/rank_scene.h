// A source drawn by several ranks, threads of this process, each with a session, a device and a
// budget of its own, as the program's ranks are.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "src/parallel/communication/in_process.h"
#include "src/parallel/compositing.h"
#include "src/parallel/part_device.h"
#include "src/parallel/rank_blocks.h"
#include "tests/device/suite_device.h"
#include "tests/render/render_scene.h"

namespace sluice {

using DeviceMaker = std::function<std::unique_ptr<Device>()>;
inline std::unique_ptr<Device> makeSuiteDevice() {
  return suiteDevice();
}

// Returns rank 0's picture and expects that all ranks ended without failure. `seen` gets the report
// of each frame of each rank, on that rank's thread.
inline FloatPicture drawOnRanks(int ranks, VolumeSource& source, const TransferFunction& transfer,
                                SceneOptions scene_options, const FrameOptions& options,
                                const DeviceMaker& maker = makeSuiteDevice, int frames = 1,
                                const std::function<void(const FrameReport&)>& seen = {}) {
  FloatPicture result;
  std::atomic<int64_t> blocks = 0;
  const BlockLayout layout = blockLayout(source.layout().dims, scene_options.block_vox,
                                         scene_options.lit || scene_options.ghost ? 1 : 0);
  const auto ends = runInProcess(ranks, [&](Team& team) {
    WorkerPool pool(1);
    const Dealing dealing = dealBlocks(layout, ranks);
    PartDevice device(maker(), dealing);
    RenderScene scene(device, source, transfer, scene_options);
    RankBlocks mine(dealing, team.rank(), pool);
    scene.session().chooseBlocksBy(&mine);
    for (int i = 0; i < frames; ++i) {
      const Frame frame = scene.frame(options);
      blocks += frame.report.blocks.grey + frame.report.blocks.black;
      if (seen) seen(frame.report);
      CompositingReport report;
      Picture picture =
          composite(team, device.takePart(), device.setup(), pool, UINT64_MAX, report);
      if (team.isFirst())
        result = {picture.width, picture.height, std::move(picture.rgba), std::move(picture.depth)};
      else
        EXPECT_TRUE(picture.rgba.empty());
    }
  });
  EXPECT_THAT(ends, testing::Each(std::string()));
  EXPECT_GT(blocks, 0);
  return result;
}

}  // namespace sluice
