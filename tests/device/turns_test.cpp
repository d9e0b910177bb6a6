// Several devices on one thread, and frames that are stopped.
#include <gtest/gtest.h>

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
