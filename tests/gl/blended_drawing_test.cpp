// The GL device draws blocks whose boxes have the same chunks together, and refuses too few texture
// units before it draws anything.
#include "src/gl/blended_drawing.h"

#include <gmock/gmock.h>

#include "src/base/error.h"
#include "tests/gl/test_device.h"

namespace sluice {
namespace {

BoxDraw box(uint64_t chunk, int64_t x, uint32_t channel, bool joins) {
  BoxDraw result;
  result.chunk = chunk;
  result.cells = {{x, 0, 0}, {x + 4 + channel, 8, 8}};
  result.channel = channel;
  result.joins = joins;
  return result;
}

TEST(BlendedDrawing, takesBlocksTogetherUntilAChunkChanges) {
  const std::vector<BoxDraw> boxes = {box(1, 0, 0, false), box(7, 0, 1, true),
                                      box(7, 8, 1, false),  // the first channel shows nothing
                                      box(2, 16, 0, false), box(7, 16, 1, true)};
  std::span<const BoxDraw> left = boxes;
  const BlendedBlocks first = takeBlocks(left, 3);
  ASSERT_EQ(first.hulls.size(), 2U);
  EXPECT_EQ(first.hulls[0].cells.hi.x, 5);  // of the larger box
  EXPECT_EQ(first.chunks, (std::vector<std::optional<uint64_t>>{1, 7, std::nullopt}));
  ASSERT_EQ(first.boxes.size(), 6U);
  EXPECT_TRUE(first.boxes[2].cells.empty());
  EXPECT_TRUE(first.boxes[3].cells.empty());
  EXPECT_EQ(first.boxes[4].cells.lo.x, 8);
  EXPECT_EQ(inGroups(first, 1, 1).size(), 4U);
  const BlendedBlocks second = takeBlocks(left, 3);
  EXPECT_EQ(second.hulls.size(), 1U);
  EXPECT_EQ(second.chunks[0], 2U);
  EXPECT_TRUE(left.empty());
}

TEST(BlendedDrawing, refusesMoreTexturesThanTheDriverHas) {
  const auto context = createContext(GlChoice::kAuto);
  context->makeCurrent();
  FrameSetup setup;
  setup.look_up = std::make_shared<const LookUp>(
      LookUp{.device_range = {0, 255}, .rgba = std::vector<float>(8, 0.5F)});
  setup.others.assign(8, setup);
  BlendedDrawing few(context->functions(), 16);
  try {
    few.begin(setup, false);
    FAIL() << "16 units are not enough";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("9 channels need 20 textures at once"));
  }
  setup.others.resize(3);
  few.begin(setup, false);
}

}  // namespace
}  // namespace sluice
