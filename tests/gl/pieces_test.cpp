// What is drawn in pieces.
#include <gtest/gtest.h>

#include "src/render/frame_setup.h"
#include "tests/gl/test_device.h"
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

Picture draw(GlDevice& device, const FrameSetup& setup) {
  const BoxDraw box = wholeBox();
  device.beginFrame(setup);
  device.draw({&box, 1});
  return device.endFrame();
}

// A box of more samples than a piece may have is drawn in bands of rows: the same picture.
TEST(PiecesTest, piecesDoNotShow) {
  const auto device = testDevice();
  device->makeResident(1, texelsOf(60));
  const FrameSetup setup = setupOf({300, 260}, 0.002);
  std::vector<BoxDraw> parts;
  for (int64_t z = kDims.z - 2; z >= 0; --z) {  // the eye looks along -z
    parts.push_back(wholeBox());
    parts.back().cells.lo.z = z;
    parts.back().cells.hi.z = z + 1;
  }
  DrawingPieces pieces(setup);
  const BoxDraw box = wholeBox();
  ASSERT_GT(pieces.cut({&box, 1}).size(), 1U) << "in bands";
  const Picture whole = draw(*device, setup);
  device->beginFrame(setup);
  device->draw(parts);
  const Picture in_parts = device->endFrame();
  float most = 0;
  for (size_t i = 0; i < whole.rgba.size(); ++i)
    most = std::max(most, std::abs(whole.rgba[i] - in_parts.rgba[i]));
  EXPECT_LT(most, 1.0 / 255);
}

}  // namespace
}  // namespace sluice
