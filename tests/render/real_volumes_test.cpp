// Every real volume, through its reader, the automatic transfer function and the renderer, against
// the reference and the plain picture: lit and unlit, orthographic and perspective, eye inside too.
#include "tests/render/real_volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/render/render_scene.h"

namespace sluice {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;
// The middle of a larger volume stands for it: the reference takes every sample in doubles.
constexpr int64_t kMostVoxels = kSanitized ? 128 : 160;

class RealVolumesTest : public RenderTest, public testing::WithParamInterface<RealVolume> {};

TEST_P(RealVolumesTest, pictureIsRight) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const Vec3i dims = file->layout().dims;
  const Vec3i size = min(dims, Vec3i{kMostVoxels, kMostVoxels, kMostVoxels});
  const Vec3i lo = (dims - size) / Vec3i{2, 2, 2};
  const auto source = cropped(*file, {lo, lo + size}, GetParam().time);

  for (const bool lit : {false, true}) {
    TransferFunction transfer;
    {
      // The index knows the histogram; the scene builds its own.
      WorkerPool pool(2);
      Progress progress;
      transfer = automaticFor(
          buildSliceRanges(*source, 0, blockLayout(size, 32, 0), pool, progress), file->layout());
    }
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

INSTANTIATE_TEST_SUITE_P(Data, RealVolumesTest, testing::ValuesIn(realVolumes()),
                         [](const auto& each) { return std::string(each.param.name); });

// A volume that is put into the folder and drawn by no test would go unseen.
TEST(RealVolumes, eachEntryOfTheFolderIsDrawnByATest) {
  if (!std::filesystem::exists(realVolumesFolder()))
    GTEST_SKIP() << realVolumesFolder() << " is not there";
  for (const auto& entry : std::filesystem::directory_iterator(realVolumesFolder())) {
    const std::string name = entry.path().filename();
    // Text, what sluice keeps beside a volume, and the voxels of those headers that are named.
    if (name.ends_with(".md") || name.ends_with(".sluice-index") || name == "HeadMRVolume.raw" ||
        name == "nucleon.raw")
      continue;
    EXPECT_TRUE(std::ranges::any_of(realVolumes(), [&](const RealVolume& volume) {
      const std::string_view input = volume.input;
      return input == name || input.starts_with(name + "/");
    })) << name;
  }
}

}  // namespace
}  // namespace sluice
