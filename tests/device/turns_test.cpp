// Several devices on one thread, one with many looks, and frames that are stopped.
#include <gtest/gtest.h>

#include <memory>

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

// A device may keep what it made of a look-up, which depends on more than that.
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

}  // namespace
}  // namespace sluice
