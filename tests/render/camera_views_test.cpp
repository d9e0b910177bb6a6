// Named views, with directions worked out by hand, and pictures of a volume whose sides are known:
// upright and never mirrored, whatever the frame and however it is stored.
#include "src/render/camera/camera_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "src/render/camera/index_space.h"
#include "tests/render/render_scene.h"

namespace sluice {
namespace {

constexpr WorldFrame kFrames[] = {WorldFrame::kNone, WorldFrame::kRas, WorldFrame::kLps,
                                  WorldFrame::kPictureRows, WorldFrame::kYUp};
constexpr ViewName kViews[] = {ViewName::kPlain,  ViewName::kFront,       ViewName::kBack,
                               ViewName::kLeft,   ViewName::kRight,       ViewName::kTop,
                               ViewName::kBottom, ViewName::kThreeQuarter};

ViewAxes axesFor(ViewName view, WorldFrame frame, std::optional<Vec3d> up = {}) {
  return turned(frontAxes(view, frame, up), turnOf(view, frame));
}

void expectAxes(const ViewAxes& found, Vec3d right, Vec3d up) {
  EXPECT_LT(length(found.right - right), 1e-12)
      << "right " << found.right.x << " " << found.right.y << " " << found.right.z;
  EXPECT_LT(length(found.up - up), 1e-12)
      << "up " << found.up.x << " " << found.up.y << " " << found.up.z;
}

TEST(CameraViews, eachIsARightHandedSystem) {
  for (const WorldFrame frame : kFrames)
    for (const ViewName view : kViews)
      for (const std::optional<Vec3d> up :
           {std::optional<Vec3d>{}, {{0, 0, 1}}, {{0, 1, 0}}, {{-1, 0, 0}}, {{1, -2, 3}}}) {
        const ViewAxes axes = axesFor(view, frame, up);
        EXPECT_NEAR(dot(cross(axes.right, axes.up), axes.back), 1, 1e-12);
        for (const Vec3d& axis : {axes.right, axes.up, axes.back})
          EXPECT_NEAR(length(axis), 1, 1e-12);
      }
}

// x of RAS points to the patient's right, x of LPS to the left; a viewer from the front has the
// patient's left on the right.
TEST(CameraViews, patientsAreSeenFromTheFrontWithTheHeadUp) {
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kRas), {-1, 0, 0}, {0, 0, 1});
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kLps), {1, 0, 0}, {0, 0, 1});
  // From the patient's left the face looks to the left of the picture.
  expectAxes(axesFor(ViewName::kLeft, WorldFrame::kRas), {0, -1, 0}, {0, 0, 1});
  expectAxes(axesFor(ViewName::kLeft, WorldFrame::kLps), {0, 1, 0}, {0, 0, 1});
  expectAxes(axesFor(ViewName::kRight, WorldFrame::kLps), {0, -1, 0}, {0, 0, 1});
  expectAxes(axesFor(ViewName::kBack, WorldFrame::kRas), {1, 0, 0}, {0, 0, 1});
  // From above the face is below.
  expectAxes(axesFor(ViewName::kTop, WorldFrame::kRas), {-1, 0, 0}, {0, -1, 0});
  expectAxes(axesFor(ViewName::kBottom, WorldFrame::kRas), {-1, 0, 0}, {0, 1, 0});
}

TEST(CameraViews, slicesShowTheirRowsFromTopToBottom) {
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kPictureRows), {1, 0, 0}, {0, -1, 0});
  // The first slice is nearest.
  EXPECT_NEAR(axesFor(ViewName::kFront, WorldFrame::kPictureRows).back.z, -1, 1e-12);
}

TEST(CameraViews, otherSidesAreThoseOfWhoLooks) {
  for (const WorldFrame frame : {WorldFrame::kNone, WorldFrame::kYUp}) {
    expectAxes(axesFor(ViewName::kFront, frame), {1, 0, 0}, {0, 1, 0});
    expectAxes(axesFor(ViewName::kLeft, frame), {0, 0, 1}, {0, 1, 0});
    expectAxes(axesFor(ViewName::kRight, frame), {0, 0, -1}, {0, 1, 0});
    expectAxes(axesFor(ViewName::kTop, frame), {1, 0, 0}, {0, 0, -1});
  }
}

TEST(CameraViews, plainIsTheSameWhateverTheAxesMean) {
  for (const WorldFrame frame : kFrames)
    expectAxes(axesFor(ViewName::kPlain, frame), {1, 0, 0}, {0, 1, 0});
}

TEST(CameraViews, threeQuarterIsTheFrontTurnedToTheRightAndLifted) {
  for (const WorldFrame frame : kFrames) {
    const ViewAxes front = axesFor(ViewName::kFront, frame);
    const ViewAxes axes = axesFor(ViewName::kThreeQuarter, frame);
    EXPECT_NEAR(dot(axes.back, front.up), std::sin(20 * M_PI / 180), 1e-12);
    EXPECT_NEAR(dot(axes.back, front.right), std::cos(20 * M_PI / 180) * 0.5, 1e-12);
    EXPECT_GT(dot(axes.back, front.back), 0.8);
    EXPECT_NEAR(dot(axes.right, front.up), 0, 1e-12) << "the horizon is level";
  }
}

TEST(CameraViews, aGivenUpIsUpAndTheFrontStaysWhereItCan) {
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kNone, Vec3d{0, -5, 0}), {-1, 0, 0}, {0, -1, 0});
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kNone, Vec3d{2, 0, 0}), {0, -1, 0}, {1, 0, 0});
  // An up direction along the view tips it over, so that right stays right.
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kNone, Vec3d{0, 0, 3}), {1, 0, 0}, {0, 0, 1});
  expectAxes(axesFor(ViewName::kFront, WorldFrame::kNone, Vec3d{0, 0, -3}), {1, 0, 0}, {0, 0, -1});
  EXPECT_NEAR(axesFor(ViewName::kFront, WorldFrame::kNone, Vec3d{0, 0, 1}).back.y, -1, 1e-12);
}

// A bead that lies in one direction of the world from the middle of the volume.
constexpr int64_t kSide = 40;
constexpr double kBeadAt = 14, kBeadRadius = 4;

std::unique_ptr<MemorySource> beadAt(VolumeLayout layout, Vec3d toward) {
  layout.dims = {kSide, kSide, kSide};
  const Vec3d middle = worldFromIndex(layout, Vec3d{1, 1, 1} * (0.5 * (kSide - 1)));
  return makeMemorySource<uint8_t>(layout, [&](int64_t x, int64_t y, int64_t z) {
    const Vec3d p = worldFromIndex(layout, toDouble({x, y, z})) - middle;
    return length(p - toward * kBeadAt) < kBeadRadius ? 200 : 0;
  });
}

// The middle of the visible pixels, from -1 to 1 to the right and up.
Vec3d placeOf(const FloatPicture& picture) {
  double x = 0, y = 0, count = 0;
  for (int j = 0; j < picture.height; ++j)
    for (int i = 0; i < picture.width; ++i) {
      if (picture.at(i, j)[3] < 0.5F) continue;
      ++count;
      x += 2 * (i + 0.5) / picture.width - 1;
      y += 1 - 2 * (j + 0.5) / picture.height;
    }
  EXPECT_GT(count, 4);
  return {x / count, y / count, 0};
}

// Stored every way: along the world's axes, mirrored (left-handed), permuted, oblique.
std::vector<VolumeLayout> storedEveryWay() {
  std::vector<VolumeLayout> layouts;
  const std::array<Vec3d, 3> ways[] = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                       {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                       {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}},
                                       {{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}},
                                       {{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}},
                                       {{{0.36, 0.48, -0.8}, {0.8, -0.6, 0}, {0.48, 0.64, 0.6}}}};
  for (const auto& axes : ways) {
    layouts.emplace_back();
    layouts.back().axes = axes;
    layouts.back().origin = {30, -10, 5};
  }
  return layouts;
}

class ViewPictureTest : public RenderTest {};

TEST_F(ViewPictureTest, isUprightAndNotMirroredHoweverTheVolumeIsStored) {
  // For each frame, the world directions to the right, up, and toward a viewer of the front.
  const std::map<WorldFrame, std::array<Vec3d, 3>> sides = {
      {WorldFrame::kNone, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
      {WorldFrame::kYUp, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
      {WorldFrame::kRas, {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}},
      {WorldFrame::kLps, {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}}},
      {WorldFrame::kPictureRows, {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}}};
  // The place of each of the three in the picture of a view: 1 to the right or up, 0 in the middle.
  const std::pair<ViewName, std::array<Vec3d, 3>> views[] = {
      {ViewName::kFront, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}}},
      {ViewName::kBack, {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 0}}}},
      {ViewName::kTop, {{{1, 0, 0}, {0, 0, 0}, {0, -1, 0}}}}};
  const TransferFunction white{{{0, {1, 1, 1}}}, {{99, 0}, {100, 0.9}}, "white"};
  for (const auto& [frame, toward] : sides)
    for (VolumeLayout layout : storedEveryWay())
      for (size_t bead = 0; bead < 3; ++bead) {
        layout.frame = frame;
        const auto source = beadAt(layout, toward[bead]);
        RenderScene scene(device(), *source, white);
        FrameOptions options;
        options.size = {32, 32};
        for (const auto& [view, places] : views)
          for (const Projection projection : kProjections) {
            SCOPED_TRACE(fmt::format("frame {}, bead {}, {}, axes {} {} {}",
                                     static_cast<int>(frame), bead, name(view), layout.axes[0].x,
                                     layout.axes[0].y, layout.axes[1].x));
            options.camera.view = view;
            options.camera.projection = projection;
            const Vec3d found = placeOf(scene.draw(options));
            for (int axis = 0; axis < 2; ++axis) {
              const double expected = places[bead][axis];
              EXPECT_NEAR(expected == 0 ? found[axis] : std::copysign(0.4, expected),
                          expected == 0 ? 0 : found[axis], expected == 0 ? 0.05 : 0.12);
            }
          }
      }
}

}  // namespace
}  // namespace sluice
