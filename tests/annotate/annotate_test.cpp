// Annotations over pictures: their places, that they measure right, and that they can be read on
// any background.
#include "src/annotate/annotation_drawing.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "src/annotate/labels.h"
#include "src/annotate/parts.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

Picture filled(PictureSize size, std::array<float, 4> rgba) {
  Picture picture{size.width, size.height, {}, {}};
  for (int i = 0; i < size.width * size.height; ++i)
    picture.rgba.insert(picture.rgba.end(), rgba.begin(), rgba.end());
  return picture;
}

VolumeLayout layoutOf(WorldFrame frame) {
  VolumeLayout layout;
  layout.dims = {101, 101, 101};
  layout.spacing = {0.5, 0.5, 0.5};
  layout.unit = "millimeter";
  layout.frame = frame;
  return layout;
}

Annotations annotationsOf(const Camera& camera, PictureSize size,
                          WorldFrame frame = WorldFrame::kRas) {
  const VolumeLayout layout = layoutOf(frame);
  Annotations annotations;
  annotations.view = resolve(camera, layout, size, 1);
  annotations.target = {25, 25, 25};
  annotations.frame = frame;
  annotations.unit = layout.unit;
  annotations.transfer = thresholdTransfer(40, {0, 255});
  annotations.range = {0, 255};
  return annotations;
}

std::array<float, 3> colorAt(const Picture& picture, int x, int y) {
  const float* p =
      picture.rgba.data() +
      4 * (static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x));
  return {p[0], p[1], p[2]};
}

bool isInk(const std::array<float, 3>& rgb) {
  return rgb[0] < 0.15F && rgb[1] < 0.15F && rgb[2] < 0.15F;
}

// The longest run of ink in the lower rows: the scale bar, in pixels.
int scaleBarPixels(const Picture& picture) {
  int longest = 0;
  for (int y = picture.height * 9 / 10; y < picture.height; ++y)
    for (int x = 0, run = 0; x < picture.width; ++x) {
      run = isInk(colorAt(picture, x, y)) ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  return longest;
}

TEST(Annotate, theScaleBarIsAsLongAsItSays) {
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const PictureSize size : {PictureSize{400, 300}, {300, 600}, {1024, 768}}) {
      Camera camera;
      camera.projection = projection;
      camera.zoom = 1.3;
      Annotations annotations = annotationsOf(camera, size);
      annotations.background = {1, 1, 1};
      const Picture picture = drawAnnotations(filled(size, {1, 1, 1, 1}), annotations);
      // Two points of the world a round length apart, seen side by side at the target.
      const View& view = annotations.view;
      double unit = 2 * view.half_height / size.height;
      if (projection == Projection::kPerspective) unit *= length(annotations.target - view.eye);
      const double pixels = scaleBarPixels(picture);
      const double nearest = roundBelow(pixels * unit * 1.1);
      EXPECT_NEAR(pixels * unit, nearest, 3 * unit) << size.width;
      EXPECT_GT(pixels, 0.07 * size.width);
      EXPECT_LT(pixels, 0.25 * size.width);
    }
}

TEST(Annotate, theMiddleOfThePictureIsUntouchedAndDepthIsKept) {
  const PictureSize size{256, 256};
  Picture plain = filled(size, {0.1F, 0.2F, 0.3F, 0.5F});
  plain.depth.assign(256 * 256, 4);
  const Picture picture = drawAnnotations(plain, annotationsOf({}, size));
  EXPECT_EQ(picture.depth, plain.depth);
  for (int y = 60; y < 190; ++y)
    for (int x = 60; x < 190; ++x)
      ASSERT_EQ(colorAt(picture, x, y), (std::array{0.1F, 0.2F, 0.3F}));
  EXPECT_NE(picture.rgba, plain.rgba);
  for (const float value : picture.rgba) {
    ASSERT_GE(value, 0);
    ASSERT_LE(value, 1);
  }
}

// Each part has both dark and light pixels, so that it shows on anything.
TEST(Annotate, canBeReadOnLightAndDark) {
  const PictureSize size{320, 320};
  for (const float grey : {0.0F, 0.5F, 1.0F})
    for (const bool told : {false, true}) {
      Annotations annotations = annotationsOf({}, size);
      if (told) annotations.background = {grey, grey, grey};
      const Picture picture = drawAnnotations(filled(size, {grey, grey, grey, 1}), annotations);
      float least = 1, most = 0;
      for (int y = 290; y < 320; ++y)
        for (int x = 200; x < 320; ++x) {
          least = std::min(least, colorAt(picture, x, y)[1]);
          most = std::max(most, colorAt(picture, x, y)[1]);
        }
      EXPECT_GT(most - least, 0.85F) << grey;
    }
}

TEST(Annotate, labelsHaveAPatchEachAsFarAsThereIsRoom) {
  const PictureSize size{512, 512};
  Annotations annotations = annotationsOf({}, size);
  std::vector<double> values{0};
  for (int i = 0; i < 60; ++i) values.push_back(i < 4 ? 3 + i : 1000 + 7 * i);
  // The colours down the middle of the patches, from one paper-white stretch to the next.
  const auto patchesOf = [&](size_t count) {
    const std::vector<double> some(values.begin(), values.begin() + 1 + static_cast<int>(count));
    annotations.transfer = labelsTransfer(labelStyles(some, 0));
    annotations.legend.clear();
    for (size_t i = 1; i < some.size(); ++i)
      annotations.legend.push_back({fmt::format("{}", some[i]), labelColor(some[i])});
    const Picture picture = drawAnnotations(filled(size, {1, 1, 1, 1}), annotations);
    const int x = size.width - static_cast<int>((kFreeEms + 0.45) * emOf(size));
    const int end = size.height - static_cast<int>((kFreeEms + kScaleBarEms + 1) * emOf(size));
    size_t found = 0;
    for (int y = 0; y < end && found < count; ++y) {
      const Vec3d rgb = annotations.legend[found].rgb;
      const std::array<float, 3> pixel = colorAt(picture, x, y);
      if (length(Vec3d{pixel[0], pixel[1], pixel[2]} - rgb) < 0.01) ++found;
    }
    return found;
  };
  EXPECT_EQ(patchesOf(6), 6U);
  EXPECT_GT(patchesOf(60), 10U) << "in their order";
  EXPECT_LT(patchesOf(60), 25U);
}

// Pixels nearly of a colour of the axes, and their mean place.
std::optional<std::pair<double, double>> colored(const Picture& picture, int channel) {
  double x = 0, y = 0, count = 0;
  const int side = static_cast<int>(7 * emOf({picture.width, picture.height}));
  for (int j = picture.height - side; j < picture.height; ++j)
    for (int i = 0; i < side; ++i) {
      const std::array<float, 3> rgb = colorAt(picture, i, j);
      const auto own = static_cast<size_t>(channel);
      if (rgb[own] < rgb[(own + 1) % 3] + 0.3F || rgb[own] < rgb[(own + 2) % 3] + 0.3F) continue;
      ++count;
      x += i;
      y += j;
    }
  if (count < 5) return std::nullopt;
  return std::pair(x / count, y / count);
}

TEST(Annotate, orientationAxesPointWhereTheirNamesSay) {
  const PictureSize size{512, 512};
  const double em = emOf(size);
  const double middle_x = (kFreeEms + kAxesEms / 2) * em, middle_y = 512 - middle_x;
  Camera camera;
  camera.view = ViewName::kFront;
  for (const WorldFrame frame : {WorldFrame::kRas, WorldFrame::kLps}) {
    const Picture picture =
        drawAnnotations(filled(size, {0, 0, 0, 1}), annotationsOf(camera, size, frame));
    const auto right = colored(picture, 0), superior = colored(picture, 2);
    ASSERT_TRUE(right && superior);
    EXPECT_LT(right->first, middle_x - em) << "a patient's right is on the left";
    EXPECT_NEAR(right->second, middle_y, 0.5 * em);
    EXPECT_LT(superior->second, middle_y - em);
    EXPECT_NEAR(superior->first, middle_x, 0.5 * em);
  }
  const Picture rows = drawAnnotations(filled(size, {0, 0, 0, 1}),
                                       annotationsOf(camera, size, WorldFrame::kPictureRows));
  EXPECT_GT(colored(rows, 0)->first, middle_x + em);
  EXPECT_GT(colored(rows, 1)->second, middle_y + em) << "rows run down";
}

TEST(Annotate, theColorBarHasTheColorsOfTheValues) {
  const PictureSize size{512, 512};
  Annotations annotations = annotationsOf({}, size);
  annotations.transfer = {{{0, {1, 0, 0}}, {100, {0, 0, 1}}}, {{0, 0.1}, {100, 0.1}}, "two"};
  annotations.range = {0, 100};
  const Picture picture = drawAnnotations(filled(size, {1, 1, 1, 1}), annotations);
  const double em = emOf(size);
  const int x = static_cast<int>(512 - 1.45 * em);
  const double top = 1.5 * em, bottom = 512 - (kFreeEms + kScaleBarEms + 1) * em;
  for (const double share : {0.1, 0.5, 0.9}) {
    const auto rgb = colorAt(picture, x, static_cast<int>(bottom - share * (bottom - top)));
    EXPECT_NEAR(rgb[0], 1 - share, 0.02);
    EXPECT_NEAR(rgb[2], share, 0.02);
  }
}

TEST(Annotate, oddTransferFunctionsAndRangesAreDrawn) {
  const PictureSize size{128, 128};
  const Picture plain = filled(size, {0, 0, 0, 0});
  Annotations annotations = annotationsOf({}, size);
  for (const ValueRange range : {ValueRange{5, 5}, {0, 1e-30}, {-1e30, 1e30}, {0, 65535}}) {
    annotations.range = range;
    annotations.transfer = {{{1, {1, 1, 1}}}, {{1, 0.5}}, "one colour"};
    EXPECT_NE(drawAnnotations(plain, annotations).rgba, plain.rgba);
    annotations.transfer = {{{1, {1, 1, 1}}}, {{1, 0}}, "nothing shows"};
    EXPECT_NE(drawAnnotations(plain, annotations).rgba, plain.rgba);
  }
}

TEST(Annotate, tooSmallAPictureIsRefused) {
  const PictureSize size{127, 400};
  EXPECT_THAT(errorOf([&] {
                drawAnnotations(filled(size, {0, 0, 0, 0}), annotationsOf({}, size));
              }),
              HasSubstr("needs 128 x 128"));
}

TEST(Annotate, roomIsWhatThePartsTake) {
  for (const PictureSize size : {PictureSize{128, 128}, {512, 512}, {1920, 1080}, {300, 900}}) {
    const Room room = annotationRoom(size);
    EXPECT_GT(room.right, 0.05);
    EXPECT_LT(room.right, 0.5);
    EXPECT_GT(room.bottom, 0.02);
    EXPECT_LT(room.bottom, 0.3);
  }
}

}  // namespace
}  // namespace sluice
