// Several devices on one thread, and frames that are stopped.
#include <gtest/gtest.h>

#include "src/render/frame_setup.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{8, 8, 8};

ChunkTexelsPtr texelsOf(int value) {
  return chunkTexels(kDims, DeviceType::kU8,
                     std::vector<std::byte>(512, static_cast<std::byte>(value)));
}

FrameSetup setupOf(PictureSize size, double step_vox = 1) {
  VolumeLayout layout;
  layout.dims = kDims;
  FrameOptions options;
  options.size = size;
  options.step_vox = step_vox;
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {0, 0, 1}}, {255, {1, 0, 0}}}, {{0, 0.01}, {255, 0.2}}, "t"};
  return frameSetup(resolve(options.camera, layout, size, step_vox), layout,
                    OpacityTable(transfer, map, {0, 255}), map, options);
}

BoxDraw wholeBox() {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kDims - Vec3i{1, 1, 1});
  return box;
}

Picture draw(Device& device, const FrameSetup& setup) {
  const BoxDraw box = wholeBox();
  device.beginFrame(setup);
  device.draw({&box, 1});
  return device.endFrame();
}

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
