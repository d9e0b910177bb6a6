// The share of --memory that pictures have, and the strips that they are cut into.
#include "src/library/drawing/cost/picture_memory.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;

TEST(PictureMemory, isTheWholePicturesWhereThatFits) {
  const PictureDemand picture{{1000, 1000}};
  const uint64_t whole = wholePictureBytes(picture);
  EXPECT_EQ(whole, 1'000'000 * uint64_t{44} + kWrittenPixels * kWrittenPixelBytes);
  EXPECT_EQ(pictureBytes(picture, UINT64_MAX), whole);
  EXPECT_EQ(pictureBytes(picture, 4 * whole), whole);
  EXPECT_EQ(stripsOf(picture, whole).size(), 1U);
  EXPECT_LT(pictureBytes(picture, 4 * whole - 4), whole);
}

TEST(PictureMemory, isAQuarterOfTheBudgetButNeverLessThanARowOfTiles) {
  const PictureDemand picture{{4000, 4000}};
  EXPECT_EQ(pictureBytes(picture, 200 * kMiB), 50 * kMiB);
  const uint64_t least = 4000 * 32 * uint64_t{44} + kWrittenPixels * kWrittenPixelBytes;
  EXPECT_EQ(pictureBytes(picture, kMiB), least);
  EXPECT_EQ(leastPictureBytes(picture), least);
  EXPECT_LT(pictureBytes({{100, 100}}, kMiB), 2 * kMiB);
}

// The ends of rays depend on the opacity maps, which belong to the whole picture.
TEST(PictureMemory, isTheWholePicturesWithOcclusion) {
  FrameOptions frame;
  frame.size = {4000, 4000};
  for (const Occlusion occlusion : {Occlusion::kMap, Occlusion::kCull, Occlusion::kClip}) {
    frame.occlusion = occlusion;
    const PictureDemand picture = pictureDemand({}, frame);
    EXPECT_EQ(pictureBytes(picture, kMiB), wholePictureBytes(picture));
    EXPECT_EQ(stripsOf(picture, wholePictureBytes(picture)).size(), 1U);
  }
  frame.occlusion = Occlusion::kOff;
  EXPECT_LT(pictureBytes(pictureDemand({}, frame), kMiB), 20 * kMiB);
}

// The picture stays while the next one is drawn, or the one that it is compared with.
TEST(PictureMemory, isTheWholePicturesAndThatOfOneThatIsKept) {
  FrameOptions frame;
  frame.size = {4000, 4000};
  frame.strips = Strips::kNever;
  const PictureDemand picture = pictureDemand({}, frame);
  EXPECT_EQ(pictureBytes(picture, kMiB),
            wholePictureBytes({frame.size}) + 4000 * 4000 * uint64_t{20});
  EXPECT_EQ(stripsOf(picture, wholePictureBytes(picture)).size(), 1U);
}

TEST(PictureMemory, ofGlIsThatOfItsTargetsToo) {
  MachineOptions machine;
  machine.device.device = DeviceChoice::kGl;
  const FrameOptions frame;
  EXPECT_GT(wholePictureBytes(pictureDemand(machine, frame)),
            wholePictureBytes(pictureDemand({}, frame)));
}

// Strips go from the top down, have each row once, end at multiples of kRowStep and stay within
// their bytes.
TEST(PictureMemory, stripsCoverThePicture) {
  for (const PictureSize size : {PictureSize{4000, 4000}, {31, 9001}, {16384, 33}, {1, 1}})
    for (const uint64_t memory : {kMiB, 16 * kMiB, 90 * kMiB, 4000 * kMiB}) {
      const PictureDemand picture{size};
      const uint64_t bytes = pictureBytes(picture, memory);
      const auto strips = stripsOf(picture, bytes);
      int top = size.height;
      for (const PictureRows& strip : strips) {
        EXPECT_EQ(strip.hi, top);
        EXPECT_EQ(strip.lo % kRowStep, 0);
        EXPECT_LT(strip.lo, strip.hi);
        EXPECT_LE(static_cast<uint64_t>(strip.hi - strip.lo) * kCpuPixelBytes *
                      static_cast<uint64_t>(size.width),
                  bytes);
        top = strip.lo;
      }
      EXPECT_EQ(top, 0);
    }
}

}  // namespace
}  // namespace sluice
