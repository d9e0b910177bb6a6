// Several devices on one thread, one with many looks, and frames that are stopped.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <utility>

#include "tests/device/one_box.h"
#include "tests/device/suite_device.h"

namespace sluice {
namespace {

TEST(TurnsTest, twoDevicesTakeTurnsOnOneThread) {
  const FrameSetup setup = setupOf({40, 30});
  const auto first = suiteDevice();
  first->makeResident(1, texelsOf(60));
  const Picture dark = draw(*first, setup);
  auto second = suiteDevice();
  second->makeResident(1, texelsOf(220));
  const Picture bright = draw(*second, setup);
  EXPECT_NE(bright.rgba, dark.rgba);
  EXPECT_EQ(draw(*first, setup).rgba, dark.rgba);
  EXPECT_EQ(draw(*second, setup).rgba, bright.rgba);
  // Also in the middle of a frame.
  const BoxDraw box = wholeBox();
  first->beginFrame(setup);
  second->beginFrame(setup);
  first->draw({&box, 1});
  second->draw({&box, 1});
  EXPECT_EQ(first->endFrame().rgba, dark.rgba);
  EXPECT_EQ(second->endFrame().rgba, bright.rgba);
  second.reset();
  EXPECT_EQ(draw(*first, setup).rgba, dark.rgba);
}

// A device may keep tables made from a look-up, which depend on more than that.
TEST(TurnsTest, eachFrameHasTheLookOfItsOwnSetup) {
  const FrameSetup plain = setupOf({40, 30});
  FrameSetup fine = setupOf({40, 30}, 0.25);
  fine.look_up = plain.look_up;  // the same object, for another step
  FrameSetup greatest = plain;
  greatest.mode = Mode::kMip;
  FrameSetup faint = plain;
  LookUp changed = *plain.look_up;
  for (size_t i = 3; i < changed.rgba.size(); i += 4) changed.rgba[i] *= 0.25F;
  faint.look_up = std::make_shared<const LookUp>(changed);
  const auto kept = suiteDevice();
  kept->makeResident(1, texelsOf(120));
  for (const FrameSetup& setup : {plain, fine, plain, greatest, faint, plain, faint, fine}) {
    const auto fresh = suiteDevice();
    fresh->makeResident(1, texelsOf(120));
    const Picture expected = draw(*fresh, setup);
    EXPECT_GT(expected.rgba[4 * (15 * 40 + 20) + 3], 0.01F);
    EXPECT_EQ(draw(*kept, setup).rgba, expected.rgba);
  }
}

TEST(TurnsTest, aStoppedFrameThrowsAndTheNextIsRight) {
  const FrameSetup setup = setupOf({40, 30});
  const auto device = suiteDevice();
  device->makeResident(1, texelsOf(60));
  const Picture expected = draw(*device, setup);
  StopSource stop;
  const BoxDraw box = wholeBox();
  device->beginFrame(setup, stop.token());
  device->draw({&box, 1});
  stop.requestStop();
  EXPECT_THROW(device->draw({&box, 1}), Interrupted);
  device->cancelFrame();
  EXPECT_EQ(draw(*device, setup).rgba, expected.rgba);
}

// Boxes that were put off are dropped with the frame, wherever it was stopped, and their chunk can
// be evicted.
TEST(TurnsTest, aFrameMayBeStoppedWhereverItIsDrawn) {
  const FrameSetup setup = setupOf({40, 30});
  const BoxDraw box = wholeBox();
  MapGrid grid;
  grid.side = 4;
  grid.clip_from_map = {{{0.5, 0, -1}, {0, 0.5, -1}, {0, 0, 1}}};
  using Step = std::function<void(Device&)>;
  for (const Step& step : {Step([&](Device& device) { device.leastOpacity(grid); }),
                           Step([](Device& device) { device.stopOpaque(); }),
                           Step([](Device& device) { device.endFrame(); })}) {
    const auto device = suiteDevice();
    device->makeResident(1, texelsOf(60));
    const Picture expected = draw(*device, setup);
    StopSource stop;
    device->beginFrame(setup, stop.token());
    device->draw({&box, 1});
    stop.requestStop();
    try {
      step(*device);
    } catch (const Interrupted&) {  // a device that is through already has nothing to stop
    }
    device->cancelFrame();
    device->evict(1);
    device->makeResident(1, texelsOf(60));
    EXPECT_EQ(draw(*device, setup).rgba, expected.rgba);
  }
}

// Nothing of a frame of another size, with or without depth, is seen in the next.
TEST(TurnsTest, framesOfAnySizeFollowEachOther) {
  const auto kept = suiteDevice();
  kept->makeResident(1, texelsOf(120));
  MapGrid grid;
  grid.side = 4;
  grid.clip_from_map = {{{0.5, 0, -1}, {0, 0.5, -1}, {0, 0, 1}}};
  const BoxDraw box = wholeBox();
  for (const auto& [size, with_depth] : {std::pair{PictureSize{90, 70}, false},
                                         {PictureSize{33, 47}, true},
                                         {PictureSize{90, 70}, true},
                                         {PictureSize{17, 5}, false},
                                         {PictureSize{90, 70}, false}}) {
    FrameSetup setup = setupOf(size);
    setup.with_depth = with_depth;
    const auto fresh = suiteDevice();
    fresh->makeResident(1, texelsOf(120));
    const Picture expected = draw(*fresh, setup);
    // Asked on the way, which makes the device keep the picture so far.
    kept->beginFrame(setup);
    kept->draw({&box, 1});
    kept->leastOpacity(grid);
    const Picture picture = kept->endFrame();
    EXPECT_EQ(picture.rgba, expected.rgba) << size.width;
    EXPECT_EQ(picture.depth, expected.depth) << size.width;
  }
}

}  // namespace
}  // namespace sluice
