// The count of samples against a plain loop over pixels and slices.
#include <gtest/gtest.h>

#include <cmath>

#include "src/render/camera/index_space.h"
#include "src/render/camera/sampling_limit.h"
#include "tests/render/render_scene.h"

namespace sluice {
namespace {

// Samples this near to a face (voxels) may be rounded to either side of it.
constexpr double kNear = 1e-3;

struct Counted {
  uint64_t surely = 0, at_most = 0;
};

// `box`: cells.
Counted samplesIn(const VolumeLayout& layout, const FrameOptions& options, const Box3& box) {
  const View view = resolve(options, layout);
  const bool ortho = view.projection == Projection::kOrtho;
  const double aspect = static_cast<double>(view.size.width) / view.size.height;
  const double reach = 4 * length(toDouble(layout.dims) * layout.spacing);
  Counted counted;
  for (int j = 0; j < view.size.height; ++j)
    for (int i = 0; i < view.size.width; ++i) {
      const double u = 2 * (i + 0.5) / view.size.width - 1,
                   v = 1 - 2 * (j + 0.5) / view.size.height;
      const Vec3d aside =
          view.right * (u * aspect * view.half_height) + view.up * (v * view.half_height);
      for (int64_t k = 0; static_cast<double>(k) * view.step < reach; ++k) {
        const double depth = view.first_depth + (static_cast<double>(k) + 0.5) * view.step;
        if (!ortho && depth <= 0) continue;
        const Vec3d world = ortho ? view.eye + aside + view.forward * depth
                                  : view.eye + (view.forward + aside) * depth;
        const Vec3d p = indexFromWorld(layout, world);
        bool inside = true, near = true;
        for (int a = 0; a < 3; ++a) {
          const auto lo = static_cast<double>(box.lo[a]), hi = static_cast<double>(box.hi[a]);
          inside = inside && p[a] >= lo + kNear && p[a] < hi - kNear;
          near = near && p[a] >= lo - kNear && p[a] < hi + kNear;
        }
        counted.surely += inside ? 1 : 0;
        counted.at_most += near ? 1 : 0;
      }
    }
  return counted;
}

TransferFunction everything() {
  return {{{0, {1, 1, 1}}}, {{0, 0.01}}, "everything"};
}

void expectBetween(uint64_t found, const Counted& counted, const std::string& what) {
  EXPECT_GE(found, counted.surely) << what;
  EXPECT_LE(found, counted.at_most) << what;
  EXPECT_GT(counted.surely, 1000U) << what << ": too few to mean anything";
  EXPECT_LE(counted.at_most - counted.surely, counted.surely / 100) << what << ": too vague";
}

using SampleCountTest = RenderTest;

TEST_F(SampleCountTest, everySampleInsideTheVolumeIsCountedOnceWhateverTheBlocks) {
  VolumeLayout layout;
  layout.dims = {31, 29, 23};
  layout.spacing = {1, 1.5, 0.75};
  const auto source = makeMemorySource<uint8_t>(
      layout, [](int64_t x, int64_t y, int64_t z) { return 10 + x + y + z; });
  std::vector<FrameOptions> views = {obliqueView(Projection::kOrtho, {61, 53}),
                                     obliqueView(Projection::kPerspective, {61, 53}),
                                     insideView(layout, {0.3, 0.6, 0.5}, {0.9, 0.2, 0.4})};
  views.push_back(views[0]);
  views.back().step_vox = 0.25;
  for (size_t i = 0; i < views.size(); ++i) {
    FrameOptions options = views[i];
    options.count_samples = true;
    const Counted counted = samplesIn(layout, options, boxOf(layout.dims - Vec3i{1, 1, 1}));
    std::optional<uint64_t> first;
    for (const int64_t block : {4, 8, 32}) {
      RenderScene scene(device(), *source, everything(), {.block_vox = block});
      const FrameReport report = scene.frame(options).report;
      const std::string what = fmt::format("view {}, blocks of {}", i, block);
      expectBetween(report.samples_drawn, counted, what);
      EXPECT_EQ(report.samples_object, report.samples_drawn) << "all of it is object";
      if (!first) first = report.samples_drawn;
      EXPECT_EQ(report.samples_drawn, *first) << what << ": no sample twice, none left out";
    }
  }
}

// Slices and pixels that lie away from every face: not one sample is a matter of rounding.
TEST_F(SampleCountTest, straightViewIsExact) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{17, 17, 17}, [](auto...) { return 9; });
  RenderScene scene(device(), *source, everything(), {.block_vox = 8});
  FrameOptions options;
  options.count_samples = true;
  options.size = {50, 50};
  // The height of the picture is the diameter of the sphere, 16 sqrt(3): a pixel is 0.554 voxels.
  const int pixels = static_cast<int>(2 * std::floor(8 / (16 * std::sqrt(3.0) / 50) + 0.5));
  for (const double step : {0.5, 1.0, 2.0}) {
    options.step_vox = step;
    EXPECT_EQ(scene.frame(options).report.samples_drawn,
              static_cast<uint64_t>(pixels * pixels * 16 / step));
  }
}

TEST_F(SampleCountTest, objectBoxesAreWhatTheAcceleratedWaysDraw) {
  // A block of values in one corner of nothing.
  const auto source =
      makeMemorySource<uint8_t>(Vec3i{32, 32, 32}, [](int64_t x, int64_t y, int64_t z) {
        return x >= 3 && x < 12 && y >= 18 && y < 29 && z >= 5 && z < 11 ? 200 : 0;
      });
  RenderScene scene(device(), *source, {{{0, {1, 1, 1}}}, {{100, 0}, {200, 0.1}}, "object"},
                    {.block_vox = 32});
  FrameOptions options = obliqueView(Projection::kPerspective, {80, 80});
  options.count_samples = true;
  const Counted object = samplesIn(source->layout(), options, {{2, 17, 4}, {12, 29, 11}});
  const Counted all = samplesIn(source->layout(), options, boxOf({31, 31, 31}));
  for (const Algorithm algorithm : {Algorithm::kClipped, Algorithm::kTrimmed, Algorithm::kMerged}) {
    options.algorithm = algorithm;
    const FrameReport report = scene.frame(options).report;
    expectBetween(report.samples_drawn, object, std::string(name(algorithm)));
    expectBetween(report.samples_object, object, std::string(name(algorithm)));
  }
  options.algorithm = Algorithm::kConventional;
  const FrameReport report = scene.frame(options).report;
  expectBetween(report.samples_drawn, all, "conventional");
  expectBetween(report.samples_object, object, "conventional");
}

TEST_F(SampleCountTest, clipPlanesAndCropAreCounted) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{24, 24, 24}, [](auto...) { return 9; });
  RenderScene scene(device(), *source, everything(), {.block_vox = 8});
  FrameOptions options = obliqueView(Projection::kOrtho, {60, 60});
  options.count_samples = true;
  options.crop = Box3{{2, 3, 4}, {20, 19, 18}};
  expectBetween(scene.frame(options).report.samples_drawn,
                samplesIn(source->layout(), options, {{2, 3, 4}, {19, 18, 17}}), "crop");
  options.crop.reset();
  // The planes x <= 7.5 and x >= 7.5 share the volume without rest.
  const uint64_t whole = scene.frame(options).report.samples_drawn;
  options.clip_planes = {{{1, 0, 0}, 7.5}};
  const uint64_t left = scene.frame(options).report.samples_drawn;
  options.clip_planes = {{{-1, 0, 0}, -7.5}};
  const uint64_t right = scene.frame(options).report.samples_drawn;
  EXPECT_GT(left, whole / 5);
  EXPECT_LT(left, whole / 2);
  EXPECT_EQ(left + right, whole);
}

TEST_F(SampleCountTest, countingLeavesThePictureAlone) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{24, 24, 24}, [](auto...) { return 9; });
  RenderScene scene(device(), *source, everything(), {.block_vox = 8});
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kAverage}) {
    FrameOptions options = obliqueView(Projection::kPerspective, {40, 40});
    options.mode = mode;
    options.with_depth = mode == Mode::kComposite;
    const FloatPicture plain = scene.draw(options);
    options.count_samples = true;
    const FloatPicture counted = scene.draw(options);
    EXPECT_EQ(plain.rgba, counted.rgba);
    EXPECT_EQ(plain.depth, counted.depth);
    options.count_samples = false;
    EXPECT_EQ(scene.draw(options).rgba, plain.rgba);
  }
}

TEST_F(SampleCountTest, samplingLimitLeavesTheDeviceAsItWas) {
  const uint64_t before = device().uploadedBytes();
  EXPECT_GT(samplingLimit(device(), {64, 64}, 1).samples_per_second, 0);
  EXPECT_GT(samplingLimit(device(), {64, 64}, 1).samples_per_second, 0)
      << "its chunk is gone again";
  EXPECT_EQ(device().uploadedBytes() - before, copied(uint64_t{2} * 64 * 64 * 64));
}

}  // namespace
}  // namespace sluice
