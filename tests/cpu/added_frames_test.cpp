// Frames that the CPU device adds up and draws together: the sum, and what is left of one that is
// given up.
#include "src/device/pictures/added_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/cpu/test_device.h"
#include "tests/device/one_box.h"

namespace sluice {
namespace {

constexpr float kLeast = 1.0F / 512;

// The frame of a channel: the same view as of all, in a colour and of an opacity of its own.
FrameSetup channelOf(Vec3d rgb, double opacity) {
  FrameSetup setup = setupOf({40, 30});
  LookUp look_up = *setup.look_up;
  for (size_t i = 0; i < look_up.rgba.size(); i += 4) {
    for (size_t c = 0; c < 3; ++c)
      look_up.rgba[i + c] = static_cast<float>(rgb[static_cast<int>(c)] * opacity);
    look_up.rgba[i + 3] = static_cast<float>(opacity);
  }
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  return setup;
}

// The same with opacities that rise from 0, see color_ramp.h.
FrameSetup rampOf(Vec3d rgb, double most) {
  FrameSetup setup = channelOf(rgb, 1);
  LookUp look_up = *setup.look_up;
  const double entries = static_cast<double>(look_up.rgba.size() / 4);
  for (size_t i = 0; i < look_up.rgba.size(); i += 4)
    look_up.rgba[i + 3] = static_cast<float>(most * static_cast<double>(i / 4) / entries);
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
  return setup;
}

class AddedFrames : public testing::Test {
 protected:
  void SetUp() override {
    device_.makeResident(1, texelsOf(60));
    device_.makeResident(2, texelsOf(200));
  }
  static BoxDraw boxOfChunk(uint64_t chunk) {
    BoxDraw box = wholeBox();
    box.chunk = chunk;
    return box;
  }
  // A frame of the sum, or a picture of its own.
  Picture frame(const FrameSetup& setup, uint64_t chunk, const StopToken& stop = {}) {
    const BoxDraw box = boxOfChunk(chunk);
    device_.beginFrame(setup, stop);
    device_.draw({&box, 1});
    return device_.endFrame();
  }
  // The frames of two channels, drawn together.
  Picture sumOf(const FrameSetup& first, const FrameSetup& second) {
    device_.beginSum();
    frame(first, 1);
    frame(second, 2);
    return device_.endSum(kLeast).picture;
  }
  AddsFrames::Sum sumOfBoth() {
    device_.beginSum();
    EXPECT_TRUE(frame(red_, 1).rgba.empty()) << "drawn at the end";
    EXPECT_TRUE(frame(blue_, 2).rgba.empty());
    AddsFrames::Sum sum = device_.endSum(kLeast);
    device_.cancelSum();
    return sum;
  }
  // The device draws frames alone and together, and lets go of chunks.
  void expectAllIsRight() {
    EXPECT_EQ(frame(red_, 1).rgba, red_alone_.rgba);
    EXPECT_EQ(sumOfBoth().picture.rgba, both_.picture.rgba);
    device_.evict(1);
    device_.evict(2);
    device_.makeResident(1, texelsOf(60));
    device_.makeResident(2, texelsOf(200));
    EXPECT_EQ(sumOfBoth().picture.rgba, both_.picture.rgba);
    EXPECT_EQ(frame(blue_, 2).rgba, blue_alone_.rgba);
  }

  TestCpuDevice device_;
  const FrameSetup red_ = channelOf({1, 0.2, 0}, 0.05), blue_ = channelOf({0, 0.3, 1}, 0.02);
  Picture red_alone_, blue_alone_;
  AddsFrames::Sum both_;

  void drawExpected() {
    red_alone_ = frame(red_, 1);
    blue_alone_ = frame(blue_, 2);
    both_ = sumOfBoth();
  }
};

TEST_F(AddedFrames, areTheSumOfThoseDrawnAlone) {
  drawExpected();
  ASSERT_EQ(both_.picture.rgba.size(), red_alone_.rgba.size());
  float most = 0;
  for (size_t i = 0; i < red_alone_.rgba.size(); ++i) {
    EXPECT_NEAR(both_.picture.rgba[i], red_alone_.rgba[i] + blue_alone_.rgba[i], 1e-5) << i;
    most = std::max(most, both_.picture.rgba[i]);
  }
  EXPECT_GT(most, 0.2F);
  EXPECT_EQ(both_.shows, (std::vector<bool>{true, true}));
  expectAllIsRight();
}

TEST_F(AddedFrames, haveTheColorsOfTheirTables) {
  const FrameSetup red = rampOf({1, 0.2, 0}, 0.1), blue = rampOf({0, 0.3, 1}, 0.05);
  const Picture red_alone = frame(red, 1), blue_alone = frame(blue, 2);
  const Picture both = sumOf(red, blue);
  for (size_t i = 0; i < both.rgba.size(); ++i)
    EXPECT_NEAR(both.rgba[i], red_alone.rgba[i] + blue_alone.rgba[i], 1e-3) << i;
}

// The first frame of a turn is drawn channel by channel, and the next ones together.
TEST_F(AddedFrames, areToTheBitThoseOfSeveralDrawnAlone) {
  FrameSetup red = rampOf({1, 0.2, 0}, 0.1), blue = rampOf({0, 0.3, 1}, 0.05);
  red.is_one_of_several = blue.is_one_of_several = true;
  const Picture red_alone = frame(red, 1), blue_alone = frame(blue, 2);
  const Picture both = sumOf(red, blue);
  for (size_t i = 0; i < both.rgba.size(); ++i)
    EXPECT_EQ(both.rgba[i], red_alone.rgba[i] + blue_alone.rgba[i]) << i;
  red.is_one_of_several = false;
  EXPECT_NE(frame(red, 1).rgba, red_alone.rgba) << "one channel alone has the colours of its table";
}

TEST_F(AddedFrames, tellWhichOfThemShowNothing) {
  const FrameSetup clear = channelOf({1, 1, 1}, 0);
  device_.beginSum();
  frame(clear, 1);
  frame(blue_, 2);
  device_.beginFrame(red_);  // of no box
  device_.endFrame();
  EXPECT_EQ(device_.endSum(kLeast).shows, (std::vector<bool>{false, true, false}));
}

TEST_F(AddedFrames, mayBeGivenUpAfterAnyOfThem) {
  drawExpected();
  for (const int frames : {0, 1, 2}) {
    device_.beginSum();
    if (frames > 0) frame(red_, 1);
    if (frames > 1) frame(blue_, 2);
    device_.cancelSum();
    expectAllIsRight();
  }
  device_.cancelSum();  // none is under way
  expectAllIsRight();
}

TEST_F(AddedFrames, mayBeStoppedInAFrameAndAtTheEnd) {
  drawExpected();
  for (const bool at_end : {false, true}) {
    StopSource stop;
    device_.beginSum();
    frame(red_, 1, stop.token());
    if (at_end) {
      frame(blue_, 2, stop.token());
      stop.requestStop();
      EXPECT_THROW(device_.endSum(kLeast), Interrupted);
    } else {
      stop.requestStop();
      EXPECT_THROW(frame(blue_, 2, stop.token()), Interrupted);
      device_.cancelFrame();  // as a frame's run does
    }
    device_.cancelSum();
    expectAllIsRight();
  }
}

TEST_F(AddedFrames, keepTheirChunks) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  device_.makeResident(3, texelsOf(10));
  device_.beginSum();
  frame(red_, 1);
  device_.evict(3);  // that no frame draws
  EXPECT_DEATH(device_.evict(1), "is_put_off");
  device_.cancelSum();
  device_.evict(1);
}

}  // namespace
}  // namespace sluice
