// Every real volume, through its reader, the automatic transfer function and the renderer, against
// the reference and the plain picture: lit and unlit, orthographic and perspective, eye inside too.
#include "tests/render/real_volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"

namespace sluice::real_volumes_test {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;
// The middle of a larger volume stands for it: the reference takes every sample in doubles.
constexpr int64_t kMost = kSanitized ? 128 : 160;
constexpr Vec3i kMostVoxels{kMost, kMost, kMost};

class RealVolumesTest : public RenderTest, public testing::WithParamInterface<RealVolume> {};

TransferFunction automaticOf(VolumeSource& source, const VolumeLayout& layout) {
  // The index knows the histogram; the scene builds its own.
  WorkerPool pool(2);
  ProgressMeter progress;
  return automaticFor(
      buildSliceRanges(source, 0, blockLayout(source.layout().dims, 32, 0), {pool, progress}),
      layout);
}

TEST_P(RealVolumesTest, pictureIsRight) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const auto source = middleOf(*file, kMostVoxels, GetParam().time);
  const TransferFunction transfer = automaticOf(*source, file->layout());
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, transfer, {.block_vox = 32, .lit = lit});
    FrameOptions views[] = {obliqueView(Projection::kOrtho, {72, 64}),
                            obliqueView(Projection::kPerspective, {72, 64}),
                            insideView(source->layout(), {0.45, 0.55, 0.6}, {0.2, 0.4, 0.3})};
    views[2].size = {64, 48};
    for (size_t i = 0; i < std::size(views); ++i) {
      SCOPED_TRACE(fmt::format("{}, view {}, lit {}", transfer.name, i, lit));
      FrameOptions options = views[i];
      const FloatPicture drawn = scene.draw(options);
      if (i < 2) {
        EXPECT_GT(shownShare(drawn), 0.15);
      }
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
      options.algorithm = Algorithm::kConventional;
      const FloatPicture plain = scene.draw(options);
      for (const Algorithm algorithm :
           {Algorithm::kClipped, Algorithm::kTrimmed, Algorithm::kMerged}) {
        options.algorithm = algorithm;
        EXPECT_TRUE(within(kOfPlain, scene.draw(options), plain)) << name(algorithm);
      }
    }
  }
}

// Surface-like, so that it hides much. Li 2003: nothing changes at threshold 1, and little at 0.95.
TEST_P(RealVolumesTest, occlusionKeepsThePicture) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const auto source = middleOf(*file, kMostVoxels, GetParam().time);
  RenderScene scene(device(), *source, scaleOpacity(automaticOf(*source, file->layout()), 80),
                    {.block_vox = 32, .partition = Partition::kBoxes});
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const Partition partition : {Partition::kBlocks, Partition::kBoxes}) {
      FrameOptions options = obliqueView(projection, {160, 150});
      options.partition = partition;
      const FloatPicture plain = scene.draw(options);
      options.occlusion = Occlusion::kClip;
      options.opacity_threshold = 1;
      EXPECT_TRUE(within(kOfPlain, scene.draw(options), plain));
      options.opacity_threshold.reset();
      const FloatPicture usual = scene.draw(options);
      size_t differing = 0;
      for (size_t i = 0; i < plain.rgba.size(); i += 4) {
        float most = 0;
        for (size_t channel = 0; channel < 4; ++channel)
          most = std::max(most, std::abs(plain.rgba[i + channel] - usual.rgba[i + channel]));
        if (most > 13.0F / 255) ++differing;
      }
      EXPECT_LE(differing, plain.rgba.size() / 4 / 20);
    }
}

INSTANTIATE_TEST_SUITE_P(Data, RealVolumesTest, testing::ValuesIn(realVolumes()),
                         [](const auto& each) { return std::string(each.param.name); });

// A volume that is put into the folder and drawn by no test would go unseen.
TEST(RealVolumes, eachEntryOfTheFolderIsDrawnByATest) {
  if (!std::filesystem::exists(realVolumesFolder()))
    GTEST_SKIP() << realVolumesFolder() << " is not there";
  for (const auto& entry : std::filesystem::directory_iterator(realVolumesFolder())) {
    const std::string name = entry.path().filename();
    // Text, the small files of other writers that tests of readers use, sluice's own files next to
    // a volume, and the voxels of those headers that are named.
    if (name == "formats" || name.ends_with(".md") || name.ends_with(".sluice-index") ||
        name == "HeadMRVolume.raw" || name == "nucleon.raw")
      continue;
    EXPECT_TRUE(std::ranges::any_of(realVolumes(), [&](const RealVolume& volume) {
      const std::string_view input = volume.input;
      return input == name || input.starts_with(name + "/");
    })) << name;
  }
}

}  // namespace
}  // namespace sluice::real_volumes_test
