#include "src/gl/drawing_pieces.h"

#include <gtest/gtest.h>

#include "src/device/drawing_cost.h"
#include "src/render/camera/frame_setup.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

FrameSetup setupOf(Projection projection, PictureSize size = {90, 70}) {
  VolumeLayout layout;
  layout.dims = {40, 30, 50};
  FrameOptions options;
  options.size = size;
  options.camera.projection = projection;
  options.camera.azimuth_deg = 30;
  options.camera.elevation_deg = -20;
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{0, 0}, {255, 1}}, "ramp"};
  return frameSetup(resolve(options.camera, layout, size, 0.7), layout,
                    OpacityTable(transfer, map, {0, 255}), map, options);
}

std::vector<BoxDraw> boxes() {
  std::vector<BoxDraw> result;
  for (int64_t i = 0; i < 12; ++i) {
    BoxDraw box;
    box.cells = {{3 * i, i, 2 * i}, {3 * i + 5, i + 4 + i % 3, 2 * i + 7}};
    result.push_back(box);
  }
  return result;
}

TEST(AboutSamples, isNearWhatIsTaken) {
  PlainDevice device;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective}) {
    const FrameSetup setup = setupOf(projection);
    device.beginFrame(setup);
    BoxDraw box;
    box.cells = {{8, 8, 8}, {24, 20, 30}};
    const auto taken = static_cast<double>(device.countSamples({&box, 1}));
    EXPECT_NEAR(aboutSamples(setup, box.cells) / taken, 1, 0.1);
  }
}

TEST(AboutSamples, isBoundedByThePictureForAnEyeInside) {
  FrameSetup setup = setupOf(Projection::kPerspective);
  setup.clip_from_index[2][3] -= 1000;  // the eye has gone past everything
  const double samples = aboutSamples(setup, {{0, 0, 0}, {39, 29, 49}});
  EXPECT_GT(samples, 90.0 * 70);
  EXPECT_LT(samples, 90.0 * 70 * 500);
}

// However small they are.
TEST(DrawingPieces, manyListsAreWaitedFor) {
  const FrameSetup setup = setupOf(Projection::kOrtho);
  DrawingPieces pieces(setup);
  const std::vector<BoxDraw> drawn = boxes();
  int since_wait = 0;
  for (int i = 0; i < 5 * DrawingPieces::kMostLists; ++i) {
    const std::vector<DrawingPiece> cut = pieces.cut(std::span(drawn).first(1));
    ASSERT_EQ(cut.size(), 1U);
    since_wait = cut[0].waits ? 1 : since_wait + 1;
    ASSERT_LE(since_wait, DrawingPieces::kMostLists);
  }
}

// Every pixel of every box once and in order, no piece larger than allowed unless it is a row.
TEST(DrawingPieces, coverAllBoxesOnceInOrderInBoundedPieces) {
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const double most : {1.0, 50.0, 700.0, 4000.0, 1e9}) {
      const FrameSetup setup = setupOf(projection);
      DrawingPieces pieces(setup, most);
      const std::vector<BoxDraw> drawn = boxes();
      double since_wait = 0;
      for (int list = 0; list < 2; ++list) {
        size_t next = 0;
        int row = -1;  // next row of a box in bands
        const std::vector<DrawingPiece> cut = pieces.cut(drawn);
        for (const DrawingPiece& piece : cut) {
          if (piece.waits) since_wait = 0;
          if (row >= 0) {
            ASSERT_EQ(piece.row_lo, row);
          } else {
            ASSERT_EQ(piece.first, next);
          }
          const bool is_band = piece.row_lo > 0 || piece.row_hi < setup.size.height;
          ASSERT_TRUE(!is_band || piece.count == 1);
          double samples = 0;
          for (size_t i = piece.first; i < piece.first + piece.count; ++i)
            samples += aboutSamples(setup, drawn[i].cells);
          if (samples <= most) {
            since_wait += samples;
            EXPECT_LE(since_wait, most);
            next = piece.first + piece.count;
            row = -1;
            continue;
          }
          EXPECT_TRUE(piece.waits || since_wait == 0)
              << "nothing else beside a part of a large box";
          since_wait = most;
          row = piece.row_hi;
          next = piece.first;
          const bool is_last_band = &piece == &cut.back() || (&piece)[1].first != piece.first;
          if (is_last_band) row = -1, ++next;
        }
        EXPECT_EQ(next, drawn.size());
      }
    }
}

TEST(DrawingPieces, ordinaryFramesAreDrawnWithoutWaiting) {
  const FrameSetup setup = setupOf(Projection::kOrtho);
  DrawingPieces pieces(setup);
  const auto cut = pieces.cut(boxes());
  ASSERT_EQ(cut.size(), 1U);
  EXPECT_EQ(cut[0].count, 12U);
  EXPECT_FALSE(cut[0].waits);
  EXPECT_EQ(cut[0].row_lo, 0);
  EXPECT_EQ(cut[0].row_hi, 70);
}

}  // namespace
}  // namespace sluice
