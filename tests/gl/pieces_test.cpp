// Pictures that are drawn in pieces.
#include <gtest/gtest.h>

#include "tests/device/one_box.h"
#include "tests/gl/test_device.h"

namespace sluice::pieces_test {
namespace {

// A box of more samples than a piece may have is drawn in bands of rows: the same picture.
TEST(PiecesTest, piecesDoNotShow) {
  const auto device = testDevice();
  device->makeResident(1, texelsOf(60));
  const FrameSetup setup = setupOf({300, 260}, 0.002);
  std::vector<BoxDraw> parts;
  for (int64_t z = kBoxDims.z - 2; z >= 0; --z) {  // the eye looks along -z
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
}  // namespace sluice::pieces_test
