// Occlusion in the frame (Li 2003, section 4): the picture that it may change and the one that it
// may not, and its savings at each level.
#include <gtest/gtest.h>

#include "src/base/error.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{64, 60, 72};
constexpr PictureSize kSize{200, 180};
// Room for a part of the data that the frames need.
constexpr SceneOptions kLittleMemory{
    .block_vox = 16, .pages = 128, .memory_bytes = uint64_t{12} << 20};

// An opaque wall, wider than the blobs behind it, seen from +z.
std::unique_ptr<FunctionSource> wallBeforeBlobs() {
  VolumeLayout layout;
  layout.dims = kDims;
  return std::make_unique<FunctionSource>(layout, [](int64_t, Vec3i v) {
    if (v.z > 64) return v.z < 69 ? 255.0 : 0.0;
    const bool inside = v.x > 14 && v.x < 50 && v.y > 14 && v.y < 46 && v.z < 50;
    return inside ? 60.0 + static_cast<double>((v.x * 7 + v.y * 5 + v.z * 3) % 120) : 0.0;
  });
}

TransferFunction opaqueAbove(double threshold) {
  return {{{0, {0.9, 0.5, 0.2}}, {255, {0.3, 0.6, 1}}},
          {{threshold, 0}, {threshold + 1, 0.9}, {255, 1}},
          "surface"};
}

FrameOptions straight(Projection projection) {
  FrameOptions options;
  options.size = kSize;
  options.camera.projection = projection;
  options.camera.azimuth_deg = 4;
  options.camera.elevation_deg = -3;
  return options;
}

// The share of pixels with a channel that differs by more than `least_255` / 255.
double differingShare(const Picture& a, const Picture& b, double least_255) {
  size_t differing = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    double most = 0;
    for (size_t channel = 0; channel < 4; ++channel)
      most = std::max(most, std::abs(double{a.rgba[i + channel]} - b.rgba[i + channel]));
    if (most > least_255 / 255) ++differing;
  }
  return static_cast<double>(differing) / static_cast<double>(a.rgba.size() / 4);
}

using OcclusionTest = RenderTest;

TEST_F(OcclusionTest, atThresholdOneNoPictureChanges) {
  BlobOptions blobs;
  blobs.dims = kDims;
  blobs.type = VoxelType::kU8;
  blobs.blobs = 20;
  const auto source = makeSparseBlobs(blobs);
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, opaqueAbove(30),
                      {.block_vox = 16, .lit = lit, .partition = Partition::kBoxes});
    for (const Projection projection : kProjections)
      for (const double azimuth : {0.0, 37.0, 140.0, 250.0})
        for (const Partition partition : {Partition::kBlocks, Partition::kBoxes}) {
          FrameOptions options = straight(projection);
          options.camera.azimuth_deg = azimuth;
          options.partition = partition;
          options.opacity_threshold = 1;
          const Frame expected = scene.frame(options);
          for (const Occlusion occlusion : {Occlusion::kMap, Occlusion::kCull, Occlusion::kClip}) {
            options.occlusion = occlusion;
            const Frame frame = scene.frame(options);
            EXPECT_GT(frame.report.occlusion.updates, 0);
            EXPECT_EQ(frame.picture.rgba, expected.picture.rgba)
                << "lit " << lit << " azimuth " << azimuth << " partition "
                << static_cast<int>(partition) << " occlusion " << static_cast<int>(occlusion);
          }
        }
  }
}

TEST_F(OcclusionTest, eyesInsideTheVolumeSeeTheSame) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30), {.block_vox = 16});
  for (const Vec3d eye : {Vec3d{32, 30, 60}, Vec3d{5, 5, 30}, Vec3d{32, 30, 20}}) {
    FrameOptions options = straight(Projection::kPerspective);
    options.camera.look_at = Camera::LookAt{eye, {30, 28, 10}};
    options.opacity_threshold = 1;
    const Frame expected = scene.frame(options);
    options.occlusion = Occlusion::kClip;
    EXPECT_EQ(scene.frame(options).picture.rgba, expected.picture.rgba);
  }
}

TEST_F(OcclusionTest, whatAWallHidesIsCulledAndTheRestClipped) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30), {.block_vox = 16});
  for (const Projection projection : kProjections) {
    FrameOptions options = straight(projection);
    const Frame all = scene.frame(options);
    std::vector<OcclusionReport> reports;
    for (const Occlusion occlusion : {Occlusion::kMap, Occlusion::kCull, Occlusion::kClip}) {
      options.occlusion = occlusion;
      const Frame frame = scene.frame(options);
      reports.push_back(frame.report.occlusion);
      EXPECT_LE(differingShare(frame.picture, all.picture, 13), 0.05);
    }
    const auto& [map, cull, clip] = std::tie(reports[0], reports[1], reports[2]);
    EXPECT_EQ(map.cells_culled + map.cells_clipped, 0);
    EXPECT_EQ(cull.cells_clipped, 0);
    EXPECT_EQ(cull.cells, map.cells);
    EXPECT_EQ(clip.cells, map.cells);
    // Three quarters of the object's cells lie behind the wall; with three updates the first comes
    // after a quarter of all, and layers of blocks reach behind the wall before they are through
    // it.
    EXPECT_GT(cull.skippedShare(), 0.4);
    EXPECT_GT(clip.skippedShare(), 0.4);
    EXPECT_GT(cull.chunks_hidden, 0);
  }
}

TEST_F(OcclusionTest, aHoleInTheWallIsSeenThrough) {
  VolumeLayout layout;
  layout.dims = kDims;
  FunctionSource source(layout, [](int64_t, Vec3i v) {
    const bool hole = v.x > 28 && v.x < 33 && v.y > 30 && v.y < 34;
    if (v.z > 64) return v.z < 69 && !hole ? 255.0 : 0.0;
    return v.z < 20 ? 90.0 : 0.0;
  });
  RenderScene scene(device(), source, opaqueAbove(30), {.block_vox = 16});
  FrameOptions options = straight(Projection::kOrtho);
  const Frame all = scene.frame(options);
  options.occlusion = Occlusion::kClip;
  options.opacity_threshold = 1;
  const Frame clipped = scene.frame(options);
  EXPECT_EQ(clipped.picture.rgba, all.picture.rgba);
  EXPECT_GT(clipped.report.occlusion.cells_clipped, 0) << "the floor but for what the hole shows";
}

// A long beam behind a wall: of its many clusters, only those are read that the read-ahead had
// begun before the wall was drawn, and none once a frame has found which are hidden.
TEST_F(OcclusionTest, hiddenBlocksAreNeitherReadNorUploaded) {
  VolumeLayout layout;
  layout.dims = {64, 64, 640};
  FunctionSource source(layout, [](int64_t, Vec3i v) {
    if (v.z > 600) return 255.0;
    return std::min(v.x, v.y) > 12 && std::max(v.x, v.y) < 52 ? 90.0 : 0.0;
  });
  CountingSource counting(source);
  RenderScene scene(device(), counting, opaqueAbove(30), kLittleMemory);
  FrameOptions options = straight(Projection::kOrtho);
  options.camera.azimuth_deg = 0;
  options.camera.elevation_deg = 0;
  options.camera.zoom = 10;
  counting.reset();
  const Frame all = scene.frame(options);
  const int64_t bytes_of_all = counting.counts().bytes;
  EXPECT_GT(bytes_of_all, volume(layout.dims) / 2);
  options.occlusion = Occlusion::kCull;
  RenderScene fresh(device(), counting, opaqueAbove(30), kLittleMemory);
  counting.reset();
  const Frame first = fresh.frame(options);
  EXPECT_LE(differingShare(first.picture, all.picture, 13), 0.05);
  EXPECT_LT(counting.counts().bytes, bytes_of_all / 2);
  EXPECT_LT(first.report.pages_loaded, all.report.pages_loaded / 2);
  EXPECT_GT(first.report.occlusion.chunks_hidden, all.report.chunks / 2);
  options.camera.azimuth_deg = 0.2;  // hidden chunks stay hidden
  counting.reset();
  const Frame second = fresh.frame(options);
  for (const CountingSource::Read& read : counting.reads())
    EXPECT_GT(read.box.hi.z, 500)
        << "the wall, and what is drawn until it is known to hide the rest";
  EXPECT_LT(second.report.copied_bytes, all.report.copied_bytes / 2);
}

TEST_F(OcclusionTest, aTurnedViewUploadsWhatComesIntoSight) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30),
                    {.block_vox = 16, .pages = 256, .memory_bytes = uint64_t{10} << 20});
  FrameOptions options = straight(Projection::kOrtho);
  options.occlusion = Occlusion::kClip;
  scene.frame(options);
  options.camera.azimuth_deg = 184;  // from behind: the blobs before the wall
  const Frame turned = scene.frame(options);
  options.occlusion = Occlusion::kOff;
  EXPECT_LE(differingShare(turned.picture, scene.frame(options).picture, 13), 0.05);
}

TEST_F(OcclusionTest, raysThatEndAndPixelsThatStopTakeFewerSamples) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30), {.block_vox = 16});
  FrameOptions options = straight(Projection::kOrtho);
  options.count_samples = true;
  const FrameReport all = scene.frame(options).report;
  EXPECT_EQ(all.samples_taken, all.samples_drawn);
  options.opacity_threshold = 0.95;
  const FrameReport ending = scene.frame(options).report;
  EXPECT_EQ(ending.samples_drawn, all.samples_drawn);
  EXPECT_LT(ending.samples_taken, all.samples_taken);
  options.occlusion = Occlusion::kClip;
  const FrameReport clipped = scene.frame(options).report;
  EXPECT_LT(clipped.samples_drawn, ending.samples_drawn);
  EXPECT_LT(clipped.samples_taken, ending.samples_taken);
}

TEST_F(OcclusionTest, aFrameThatFailsLeavesNothingToTheNext) {
  const auto source = wallBeforeBlobs();
  RenderScene whole(device(), *source, opaqueAbove(30), kLittleMemory);
  FrameOptions options = straight(Projection::kOrtho);
  options.opacity_threshold = 1;
  const Frame expected = whole.frame(options);
  options.occlusion = Occlusion::kCull;
  for (const int64_t read : {0, 3, 6}) {
    FailingSource failing(*source, FailingSource::Failure::kError, read);
    const auto session = whole.sessionOver(failing);
    session->setOptions(options);
    EXPECT_THROW(session->frame(), Error);
    EXPECT_EQ(session->frame().picture.rgba, expected.picture.rgba);
  }
}

// The data that a time limit left out was not hidden: the next frames have it.
TEST_F(OcclusionTest, limitedFramesAreCompletedByTheNext) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30), kLittleMemory);
  FrameOptions options = straight(Projection::kOrtho);
  options.opacity_threshold = 1;
  options.occlusion = Occlusion::kCull;
  options.time_limit_s = 0;
  for (int i = 0; i < 1000 && scene.session().frame().report.missing_share > 0; ++i)
    scene.session().setOptions(options);
  options.time_limit_s.reset();
  const Frame complete = scene.frame(options);
  options.occlusion = Occlusion::kOff;
  EXPECT_EQ(complete.picture.rgba, scene.frame(options).picture.rgba);
}

// Figure 8: blending the phases between updates gives the picture.
TEST_F(OcclusionTest, phasesBlendToThePicture) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, {{{0, {0.9, 0.5, 0.2}}}, {{30, 0}, {255, 0.3}}, "soft"},
                    {.block_vox = 16});
  for (const Occlusion occlusion : {Occlusion::kMap, Occlusion::kCull}) {
    FrameOptions options = straight(Projection::kPerspective);
    options.occlusion = occlusion;
    options.keep_phases = true;
    const Frame frame = scene.frame(options);
    ASSERT_EQ(frame.phases.size(), static_cast<size_t>(frame.report.occlusion.updates) + 1);
    EXPECT_FALSE(frame.phases.front().map.has_value());
    std::vector<float> blended(frame.picture.rgba.size());
    for (const FramePhase& phase : frame.phases)
      for (size_t i = 0; i < blended.size(); i += 4) {
        const float left = 1 - blended[i + 3];
        for (size_t channel = 0; channel < 4; ++channel)
          blended[i + channel] += left * phase.picture.rgba[i + channel];
      }
    double most = 0;
    for (size_t i = 0; i < blended.size(); ++i)
      most = std::max(most, std::abs(double{blended[i]} - frame.picture.rgba[i]));
    EXPECT_LT(most, 0.5 / 255);
    options.keep_phases = false;
    EXPECT_TRUE(scene.frame(options).phases.empty());
  }
}

TEST_F(OcclusionTest, modesWithoutOpacityHaveNone) {
  const auto source = wallBeforeBlobs();
  RenderScene scene(device(), *source, opaqueAbove(30), {.block_vox = 16});
  FrameOptions options = straight(Projection::kOrtho);
  options.occlusion = Occlusion::kClip;
  options.mode = Mode::kMip;
  EXPECT_THROW(scene.frame(options), Error);
  options.mode = Mode::kComposite;
  EXPECT_EQ(scene.frame(options).picture.width, kSize.width) << "and the session goes on";
}

}  // namespace
}  // namespace sluice
