// Every real volume, through its reader, the automatic transfer function and the renderer, against
// the reference and the plain picture: lit and unlit, orthographic and perspective, eye inside too.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <ostream>

#include "io/open_volume.h"
#include "src/classify/transfer_makers.h"
#include "src/render/index_space.h"
#include "tests/render/render_scene.h"

namespace sluice {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;
// The middle of a larger volume stands for it: the reference takes every sample in doubles.
constexpr int64_t kMostVoxels = kSanitized ? 64 : 160;

struct RealVolume {
  const char* path;
  Vec3d spacing{0, 0, 0};  // what a user says beside the name; 0: nothing
  friend void PrintTo(const RealVolume& volume, std::ostream* out) { *out << volume.path; }
};

const RealVolume kVolumes[] = {{"bonsai.nii.gz"},
                               {"engine.nii.gz"},
                               {"engine_256x256x128_uint8.raw"},
                               {"visible-female-head"},
                               {"cthead", {1, 1, 2}},
                               {"head-mr.nii.gz"},
                               {"motor-map.nii.gz"},
                               {"tooth/tooth.nhdr"},
                               {"headsq-quarter/quarter.nhdr"},
                               {"HeadMRVolume.mhd"},
                               {"nucleon.nrrd"},
                               {"walnut_128x96x114_uint16.raw"},
                               {"smoke.vdb"},
                               {"cube.vdb"},
                               {"sphere.vdb"},
                               {"viscous-fingers/step_000.nrrd"}};

TransferFunction automaticFor(const SliceRanges& ranges, const VolumeLayout& layout) {
  Histogram histogram = ranges.histogram;
  histogram.range = {ranges.map.valueOf(histogram.range.lo),
                     ranges.map.valueOf(histogram.range.hi)};
  AutomaticOptions options;
  options.thickness_vox = 100;
  options.signed_distance = layout.name.ends_with("(level set)");
  options.finest_spacing = finestSpacing(layout);
  return automaticTransfer(histogram, options);
}

class RealVolumesTest : public RenderTest, public testing::WithParamInterface<RealVolume> {};

TEST_P(RealVolumesTest, pictureIsRight) {
  const std::filesystem::path path = std::filesystem::path(SLUICE_DATA_DIR) / GetParam().path;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  OpenOptions open;
  if (GetParam().spacing.x > 0) open.spacing = GetParam().spacing;
  // A folder of two series, of which the numbered files are one.
  const bool two_series = path.filename() == "cthead";
  const auto file = openVolume(two_series ? (path / "%03d.tif").string() : path.string(), open);
  const Vec3i dims = file->layout().dims;
  const Vec3i size = min(dims, Vec3i{kMostVoxels, kMostVoxels, kMostVoxels});
  const Vec3i lo = (dims - size) / Vec3i{2, 2, 2};
  const auto source = cropped(*file, {lo, lo + size});

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

std::string testName(const testing::TestParamInfo<RealVolume>& info) {
  std::string name = std::filesystem::path(info.param.path).filename().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(Data, RealVolumesTest, testing::ValuesIn(kVolumes), testName);

}  // namespace
}  // namespace sluice
