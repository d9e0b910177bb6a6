// Maximum and minimum if rays pass through side faces, against answers that follow from the ray
// alone and against the plain device.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice::extremes_test {
namespace {

constexpr Vec3i kDims{19, 15, 17};

template <class ValueAt>
ChunkTexelsPtr floatsOf(const ValueAt& value_at) {
  std::vector<float> values;
  for (int64_t z = 0; z < kDims.z; ++z)
    for (int64_t y = 0; y < kDims.y; ++y)
      for (int64_t x = 0; x < kDims.x; ++x)
        values.push_back(static_cast<float>(value_at(toDouble(Vec3i{x, y, z}))));
  return chunkTexels(kDims, DeviceType::kF32, std::as_bytes(std::span(values)));
}

double rampAt(Vec3d p) {
  return 20 + 5 * p.x + 3 * p.y - 1 * p.z + 17;
}

// Grey by value, all of it visible.
FrameSetup setupOf(const FrameOptions& options) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.type = VoxelType::kF32;
  const ValueMap map = deviceMap(layout);
  const TransferFunction grey{{{0, {0, 0, 0}}, {255, {1, 1, 1}}}, {{0, 1}}, "grey"};
  return frameSetup(resolve(options, layout), layout, OpacityTable(grey, map, {0, 255}), map,
                    options);
}

// Views from which many rays enter or leave through side faces.
std::vector<FrameOptions> views(Mode mode) {
  std::vector<FrameOptions> result;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const double step : {1.0, 0.4}) {
      FrameOptions options;
      options.size = {70, 60};
      options.mode = mode;
      options.step_vox = step;
      options.camera.projection = projection;
      options.camera.azimuth_deg = 24;
      options.camera.elevation_deg = 31;
      result.push_back(options);
    }
  result.push_back(result.back());
  result.back().camera.look_at = Camera::LookAt{{9, 7, 8}, {18, 11, 5}};  // from inside
  result.push_back(result.front());
  result.back().crop = Box3{{2, 3, 1}, {17, 12, 14}};
  result.push_back(result.front());
  result.back().clip_planes = {{{0.6, -0.5, 0.6}, 9}, {{-0.3, 0.2, 1}, 11}};
  return result;
}

// The cells that are shown: in one box, or in boxes of `side` cells, or all but some in the middle.
std::vector<BoxDraw> boxesOf(const FrameSetup& setup, int64_t side) {
  std::vector<BoxDraw> boxes;
  const Box3 shown = setup.shown;
  for (int64_t z = shown.lo.z; z < shown.hi.z; z += side)
    for (int64_t y = shown.lo.y; y < shown.hi.y; y += side)
      for (int64_t x = shown.lo.x; x < shown.hi.x; x += side) {
        BoxDraw box;
        box.chunk = 1;
        box.cells = intersect({{x, y, z}, {x + side, y + side, z + side}}, shown);
        boxes.push_back(box);
      }
  return boxes;
}

Picture drawOn(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& texels,
               int64_t side) {
  device.makeResident(1, texels);
  device.beginFrame(setup);
  device.draw(boxesOf(setup, side));
  Picture picture = device.endFrame();
  device.evict(1);
  return picture;
}

// The points at which the pixel's ray enters and leaves what is shown; nothing if rounding decides.
struct Way {
  Vec3d enter, leave;
};
std::optional<Way> wayOf(const FrameSetup& setup, int x, int y_down) {
  const double px = x + 0.5, py = setup.size.height - 1 - y_down + 0.5;
  const RayGrid& rays = setup.rays;
  const Vec3d origin = rays.origin0 + rays.origin_dx * px + rays.origin_dy * py;
  const Vec3d step = rays.step0 + rays.step_dx * px + rays.step_dy * py;
  double enter = setup.first_slice > 0 ? static_cast<double>(setup.first_slice) + 0.5 : -1e9;
  double leave = 1e9;
  const auto keep = [&](double offset, Vec3d normal) {
    const double t = (offset - dot(normal, origin)) / dot(normal, step);
    if (dot(normal, step) > 0)
      leave = std::min(leave, t);
    else
      enter = std::max(enter, t);
  };
  for (int a = 0; a < 3; ++a) {
    Vec3d normal;
    normal[a] = 1;
    keep(static_cast<double>(setup.shown.hi[a]), normal);
    normal[a] = -1;
    keep(-static_cast<double>(setup.shown.lo[a]), normal);
  }
  for (const ClipPlane& plane : setup.clip_planes) keep(plane.offset, plane.normal);
  if ((leave - enter) * length(step) < 0.05) return std::nullopt;
  return Way{origin + step * enter, origin + step * leave};
}

class ExtremesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static inline std::unique_ptr<Device> device_;
};

// Along any ray a ramp has its extremes at the ends of the way.
TEST_F(ExtremesTest, aRampShowsWhereRaysEnterAndLeave) {
  const ChunkTexelsPtr ramp = floatsOf(rampAt);
  PlainDevice plain;
  for (const Mode mode : {Mode::kMip, Mode::kMinip})
    for (const FrameOptions& options : views(mode))
      for (const int64_t side : {int64_t{100}, int64_t{5}})
        for (Device* device : {device_.get(), static_cast<Device*>(&plain)}) {
          SCOPED_TRACE(fmt::format("{}: mode {} projection {} step {} crop {} clip {} side {}",
                                   device->backend(), static_cast<int>(mode),
                                   static_cast<int>(options.camera.projection), options.step_vox,
                                   options.crop.has_value(), options.clip_planes.size(), side));
          const FrameSetup setup = setupOf(options);
          const Picture picture = drawOn(*device, setup, ramp, side);
          double worst = 0;
          int seen = 0;
          for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) {
              const auto way = wayOf(setup, x, y);
              if (!way) continue;
              const std::array<double, 2> ends = {rampAt(way->enter), rampAt(way->leave)};
              const double expected =
                  mode == Mode::kMip ? std::max(ends[0], ends[1]) : std::min(ends[0], ends[1]);
              const float* rgba = &picture.rgba[static_cast<size_t>(4 * (y * picture.width + x))];
              worst = std::max(worst, std::abs(255 * rgba[0] - expected));
              worst = std::max(worst, std::abs(255 * rgba[3] - 255.0));
              ++seen;
            }
          EXPECT_GT(seen, 500);
          EXPECT_LT(worst, 0.6);
        }
}

// Whatever rounding does to a plane just outside, the end of the way is next to it.
TEST_F(ExtremesTest, noiseIsThePictureOfPlainLoops) {
  uint32_t state = 5;
  const ChunkTexelsPtr noise = floatsOf([&](Vec3d /*p*/) {
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 24);
  });
  PlainDevice plain;
  for (const Mode mode : {Mode::kMip, Mode::kMinip})
    for (const FrameOptions& options : views(mode)) {
      const FrameSetup setup = setupOf(options);
      const Picture whole = drawOn(plain, setup, noise, 100);
      for (const int64_t side : {int64_t{100}, int64_t{5}}) {
        const Picture picture = drawOn(*device_, setup, noise, side);
        float worst = 0;
        for (int y = 0; y < picture.height; ++y)
          for (int x = 0; x < picture.width; ++x) {
            if (!wayOf(setup, x, y)) continue;
            const auto at = static_cast<size_t>(4 * (y * picture.width + x));
            for (size_t c = at; c < at + 4; ++c)
              worst = std::max(worst, std::abs(picture.rgba[c] - whole.rgba[c]));
          }
        EXPECT_LT(255 * worst, 2) << "mode " << static_cast<int>(mode) << " side " << side;
      }
    }
}

// Ends of the way are samples of the boxes in which they lie, and of no other.
TEST_F(ExtremesTest, blocksAddNoSamplesOfTheirOwnButOnSharedPlanes) {
  for (const FrameOptions& options : views(Mode::kMip)) {
    const FrameSetup setup = setupOf(options);
    device_->beginFrame(setup);
    device_->endFrame();
    PlainDevice plain;
    plain.beginFrame(setup);
    const uint64_t whole = device_->countSamples(boxesOf(setup, 100));
    const uint64_t plainly = plain.countSamples(boxesOf(setup, 100));
    const uint64_t parts = device_->countSamples(boxesOf(setup, 5));
    const uint64_t parts_plainly = plain.countSamples(boxesOf(setup, 5));
    EXPECT_NEAR(static_cast<double>(whole), static_cast<double>(plainly), 1e-3 * plainly + 3);
    EXPECT_NEAR(static_cast<double>(parts), static_cast<double>(parts_plainly),
                1e-3 * parts_plainly + 3);
    EXPECT_GE(parts, whole);
    EXPECT_LT(static_cast<double>(parts), 1.35 * static_cast<double>(whole));
  }
}

}  // namespace
}  // namespace sluice::extremes_test
