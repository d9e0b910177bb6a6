// Gestures are checked against the renderer's own view of the same camera
// (src/render/camera/camera.h), which knows nothing of them.
#include "src/view/state/editing/camera_gestures.h"

#include <gtest/gtest.h>

#include "src/library/conversions.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

constexpr Pane kPane{320, 240};

VolumeLayout layout() {
  VolumeLayout made;
  made.dims = {48, 40, 36};
  made.spacing = {1, 2, 0.5};
  made.origin = {10, -5, 3};
  made.axes = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  return made;
}

Ground ground() {
  return groundOf(volumeInfo(layout(), {0, 1}, {}));
}

ViewOptions placed(ViewOptions::Projection projection) {
  ViewOptions view;
  view.projection = projection;
  view.look_at = ViewOptions::LookAt{{60, 40, 90}, {-20, 20, 10}};
  view.up = std::array{0.0, 1.0, 0.3};
  view.zoom = 1.7;
  return view;
}

// The pixel at which the renderer sees a world position.
PanePoint seen(const ViewOptions& options, Vec3d world, Pane pane = kPane) {
  const View view = resolve(cameraOf(options), layout(), {pane.width, pane.height}, 1);
  const Vec3d from = world - view.eye;
  const double depth = view.projection == Projection::kPerspective ? dot(from, view.forward) : 1;
  const double aspect = static_cast<double>(pane.width) / pane.height;
  const double u = dot(from, view.right) / (depth * aspect * view.half_height);
  const double v = dot(from, view.up) / (depth * view.half_height);
  return {(u + 1) / 2 * pane.width, (1 - v) / 2 * pane.height};
}

void expectSeenAt(const ViewOptions& view, Vec3d world, PanePoint at) {
  const PanePoint found = seen(view, world);
  EXPECT_NEAR(found.x, at.x, 1e-6);
  EXPECT_NEAR(found.y, at.y, 1e-6);
}

class CameraGestures : public testing::TestWithParam<ViewOptions::Projection> {
 protected:
  const ViewOptions view_ = placed(GetParam());
};

TEST_P(CameraGestures, pixelsAndWorldAreTheRenderers) {
  for (const Pane pane : {kPane, Pane{100, 300}}) {
    const Vec3d world = worldAt(view_, 30, 200, pane, ground());
    const PanePoint found = seen(view_, world, pane);
    EXPECT_NEAR(found.x, 30, 1e-6);
    EXPECT_NEAR(found.y, 200, 1e-6);
    const auto back = paneOf(view_, {3, 4, 5}, pane, ground());
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->x, seen(view_, {3, 4, 5}, pane).x, 1e-6);
    EXPECT_NEAR(back->y, seen(view_, {3, 4, 5}, pane).y, 1e-6);
  }
}

TEST_P(CameraGestures, panFollowsTheHand) {
  const Vec3d held = worldAt(view_, 100, 80, kPane, ground());
  expectSeenAt(pan(view_, 17, -9, kPane, ground()), held, {117, 71});
}

TEST_P(CameraGestures, zoomKeepsWhatIsUnderThePointer) {
  const Vec3d under = worldAt(view_, 250, 30, kPane, ground());
  const ViewOptions nearer = zoomTo(view_, 1.5, 250, 30, kPane, ground());
  expectSeenAt(nearer, under, {250, 30});
  EXPECT_NEAR(worldPerPixel(nearer, kPane, ground()) * 1.5, worldPerPixel(view_, kPane, ground()),
              1e-9);
  // And back again.
  const ViewOptions back = zoomTo(nearer, 1 / 1.5, 250, 30, kPane, ground());
  for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(back.look_at->eye[a], view_.look_at->eye[a], 1e-6);
}

TEST_P(CameraGestures, orbitKeepsTheTargetAndTheDistance) {
  const ViewOptions turned = orbit(view_, 40, -25, kPane);
  EXPECT_EQ(turned.look_at->target, view_.look_at->target);
  const auto distance = [](const ViewOptions& view) {
    double sum = 0;
    for (size_t a = 0; a < 3; ++a)
      sum += std::pow(view.look_at->eye[a] - view.look_at->target[a], 2);
    return std::sqrt(sum);
  };
  EXPECT_NEAR(distance(turned), distance(view_), 1e-9);
  // Points in front of the target follow the drag.
  const PlacedAxes axes = axesOf(view_);
  const auto& t = view_.look_at->target;
  const Vec3d front = Vec3d{t[0], t[1], t[2]} + axes.back * 5;
  EXPECT_GT(seen(turned, front).x, seen(view_, front).x);
  EXPECT_LT(seen(turned, front).y, seen(view_, front).y);
  // Half a turn across the shorter side looks from behind.
  const PlacedAxes behind = axesOf(orbit(view_, 240, 0, kPane));
  EXPECT_NEAR(dot(behind.back, axes.back), -1, 1e-9);
}

TEST_P(CameraGestures, rollTurnsThePictureAlone) {
  const Vec3d point = worldAt(view_, 200, 120, kPane, ground());  // to the right of the middle
  const PanePoint rolled = seen(roll(view_, 90), point);
  EXPECT_NEAR(rolled.x, 160, 1e-6);
  EXPECT_NEAR(rolled.y, 160, 1e-6);
}

TEST_P(CameraGestures, centeringBringsAPlaceToTheMiddle) {
  expectSeenAt(centerOn(view_, {1, 2, 3}), {1, 2, 3}, {160, 120});
}

TEST_P(CameraGestures, theOtherProjectionShowsTheTargetAsLarge) {
  const bool is_perspective = GetParam() == ViewOptions::Projection::kPerspective;
  const ViewOptions other = withProjection(
      view_,
      is_perspective ? ViewOptions::Projection::kParallel : ViewOptions::Projection::kPerspective,
      kPane, ground());
  EXPECT_NEAR(worldPerPixel(other, kPane, ground()), worldPerPixel(view_, kPane, ground()), 1e-9);
  const Vec3d point = worldAt(view_, 40, 50, kPane, ground());
  expectSeenAt(other, point, {40, 50});
}

TEST_P(CameraGestures, theHeadTurnsAboutTheEye) {
  const ViewOptions turned = lookAround(view_, 30, 10, kPane);
  EXPECT_EQ(turned.look_at->eye, view_.look_at->eye);
  EXPECT_NE(turned.look_at->target, view_.look_at->target);
}

TEST_P(CameraGestures, flyingMovesEyeAndTargetTogether) {
  const ViewOptions flown = fly(view_, 0.5, 0, 0, ground());
  const PlacedAxes axes = axesOf(view_);
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    EXPECT_NEAR(flown.look_at->eye[i] - view_.look_at->eye[i], -axes.back[a] * ground().radius / 2,
                1e-9);
    EXPECT_NEAR(flown.look_at->target[i] - view_.look_at->target[i],
                -axes.back[a] * ground().radius / 2, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, CameraGestures,
                         testing::Values(ViewOptions::Projection::kParallel,
                                         ViewOptions::Projection::kPerspective),
                         [](const auto& each) {
                           return each.param == ViewOptions::Projection::kParallel ? "parallel"
                                                                                   : "perspective";
                         });

}  // namespace
}  // namespace sluice
