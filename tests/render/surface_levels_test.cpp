// Surfaces of coarser levels of resolution: where the means lie, against plain loops; no cracks
// where blocks of one level or of several meet; thin sheets are counted and kept.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/light/coarse_extinction.h"
#include "tests/render/level_scene.h"
#include "tests/render/one_light.h"

namespace sluice {
namespace {

constexpr Vec3d kBallMiddle{39.4, 40.7, 38.1};
constexpr double kBallRadius = 33.3;

double distanceAt(int64_t x, int64_t y, int64_t z) {
  return length(Vec3d{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} -
                kBallMiddle);
}
std::unique_ptr<MemorySource> ball(Vec3i dims = {80, 80, 80}, double bumps = 0) {
  VolumeLayout layout;
  layout.dims = dims;
  return makeMemorySource<float>(layout, [&](int64_t x, int64_t y, int64_t z) {
    const auto wave = [](int64_t at) { return std::sin(static_cast<double>(at) * 0.9); };
    return static_cast<float>(distanceAt(x, y, z) + bumps * wave(x) * wave(y) * wave(z));
  });
}

TransferFunction surface(double value, double opacity = 1) {
  TransferFunction transfer;
  transfer.colors = {{0, {0.2, 0.5, 1}}, {70, {1, 0.7, 0.1}}};
  transfer.opacities = {{0, 0}};
  transfer.surfaces = {{value, opacity, {1, 1, 1}}};
  return transfer;
}

FrameOptions viewOfLevel(int level, PictureSize size = {80, 80}) {
  FrameOptions options = obliqueView(Projection::kOrtho, size);
  options.cut = CutOptions{.level = level};
  options.with_depth = true;
  return options;
}

// The means of cubes of 2^level voxels, and the interpolation between them, in plain loops.
class MeanField {
 public:
  explicit MeanField(int level) : side_(int64_t{1} << level), count_(80 / side_) {
    for (int64_t z = 0; z < count_; ++z)
      for (int64_t y = 0; y < count_; ++y)
        for (int64_t x = 0; x < count_; ++x) means_.push_back(meanOf(x, y, z));
  }
  double at(Vec3d p) const {
    Vec3i first;
    Vec3d part;
    for (int a = 0; a < 3; ++a) {
      const double side = static_cast<double>(side_), most = static_cast<double>(count_ - 1);
      const double place = std::clamp((p[a] - (side - 1) / 2) / side, 0.0, most);
      first[a] = std::min(static_cast<int64_t>(place), count_ - 2);
      part[a] = place - static_cast<double>(first[a]);
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int64_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      sum += (x != 0 ? part.x : 1 - part.x) * (y != 0 ? part.y : 1 - part.y) *
             (z != 0 ? part.z : 1 - part.z) *
             means_[static_cast<size_t>(((first.z + z) * count_ + first.y + y) * count_ + first.x +
                                        x)];
    }
    return sum;
  }
  // The differences between the corners of a cube of a voxel of the level.
  Vec3d slopeAt(Vec3d p) const {
    Vec3d slope;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d side{corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5};
      slope = slope + side * at(p + side * static_cast<double>(side_));
    }
    return slope;
  }

 private:
  double meanOf(int64_t x, int64_t y, int64_t z) const {
    double sum = 0;
    for (int64_t k = 0; k < side_; ++k)
      for (int64_t j = 0; j < side_; ++j)
        for (int64_t i = 0; i < side_; ++i)
          sum += distanceAt(side_ * x + i, side_ * y + j, side_ * z + k);
    return sum / static_cast<double>(side_ * side_ * side_);
  }

  const int64_t side_, count_;
  std::vector<double> means_;
};

class SurfaceLevelsTest : public LevelCutTest {
 protected:
  static Picture pictureOf(Session& session, const FrameOptions& options) {
    session.setOptions(options);
    return session.frame().picture;
  }
  static int64_t holesIn(const FloatPicture& picture) {
    int64_t holes = 0;
    for (size_t i = 3; i < picture.rgba.size(); i += 4) holes += picture.rgba[i] < 0.99F ? 1 : 0;
    return holes;
  }
};

TEST_F(SurfaceLevelsTest, lieWhereTheInterpolatedMeansPassTheValue) {
  const auto source = ball();
  Pyramid pyramid(*source, 4, true, Spreads::kKept);
  const auto session = sessionOf(pyramid, surface(kBallRadius), true);
  for (const int level : {1, 2, 3}) {
    const MeanField field(level);
    const double voxel = 1 << level;
    FrameOptions options = viewOfLevel(level);
    const View view = viewOf(pyramid, options);
    std::array<Picture, 3> lit;
    for (int a = 0; a < 3; ++a) {
      Vec3d toward;
      toward[a] = 1;
      options.lighting = oneLight(toward);
      lit[static_cast<size_t>(a)] = pictureOf(*session, options);
    }
    double worst_place = 0, worst_angle = 0;
    int seen = 0;
    for (int j = 0; j < 80; ++j)
      for (int i = 0; i < 80; ++i) {
        const size_t pixel = static_cast<size_t>(j) * 80 + static_cast<size_t>(i);
        if (!(lit[0].rgba[4 * pixel + 3] > 0.5F)) continue;
        const double u = 2 * (i + 0.5) / 80 - 1, v = 1 - 2 * (j + 0.5) / 80;
        const Vec3d at = view.eye + view.right * (u * view.half_height) +
                         view.up * (v * view.half_height) +
                         view.forward * static_cast<double>(lit[0].depth[pixel]);
        // The distance to the surface in voxels of the level: the field's slope is 1.
        worst_place = std::max(worst_place, std::abs(field.at(at) - kBallRadius) / voxel);
        const Vec3d from = field.slopeAt(at);
        const Vec3d expected{std::abs(dot(from, view.right)), std::abs(dot(from, view.up)),
                             std::abs(dot(from, view.forward))};
        const auto of = [&](size_t a) { return static_cast<double>(lit[a].rgba[4 * pixel]); };
        const double cosine = dot(normalized(expected), normalized(Vec3d{of(0), of(1), of(2)}));
        worst_angle = std::max(worst_angle, std::acos(std::min(cosine, 1.0)));
        ++seen;
      }
    EXPECT_GT(seen, 800);
    EXPECT_LT(worst_place, 0.02) << "level " << level;
    EXPECT_LT(worst_angle * 180 / std::numbers::pi, 1) << "level " << level;
  }
}

TEST_F(SurfaceLevelsTest, levelsWithoutSpreadsHaveTheSameSurfaces) {
  const auto source = ball();
  Pyramid with(*source, 3, true, Spreads::kKept), without(*source, 3, true, Spreads::kNone);
  for (const int level : {1, 2}) {
    const FrameOptions options = viewOfLevel(level);
    const FloatPicture a = draw(*sessionOf(with, surface(kBallRadius), true), options).picture;
    const FloatPicture b = draw(*sessionOf(without, surface(kBallRadius), true), options).picture;
    EXPECT_GE(shownShare(a), 0.1);
    EXPECT_TRUE(within(1, a, b)) << level;
  }
}

TEST_F(SurfaceLevelsTest, noRaySlipsThroughBetweenTwoBlocksOfALevel) {
  const auto source = ball();
  Pyramid small(*source, 4, true, Spreads::kKept, 8), large(*source, 4, true, Spreads::kKept, 64);
  for (const int level : {1, 2, 3}) {
    FrameOptions options = viewOfLevel(level, {512, 512});
    options.camera.azimuth_deg = 33;
    options.camera.zoom = 1.7;
    const FloatPicture a = draw(*sessionOf(small, surface(kBallRadius), true), options).picture;
    const FloatPicture b = draw(*sessionOf(large, surface(kBallRadius), true), options).picture;
    EXPECT_GE(shownShare(b), 0.2);
    EXPECT_EQ(a.rgba.size(), b.rgba.size());
    int64_t holes = 0;
    for (size_t i = 3; i < a.rgba.size(); i += 4)
      holes += a.rgba[i] < 0.99F && b.rgba[i] > 0.99F ? 1 : 0;
    EXPECT_EQ(holes, 0) << "level " << level;
  }
}

// A view whose levels the width of pixels mixes, or the bytes if they are few.
FrameOptions fromInside(const VolumeLayout& layout, Vec3d toward, uint64_t bytes) {
  FrameOptions options = insideView(layout, {0.3, 0.35, 0.4}, toward);
  options.size = {256, 256};
  options.cut = CutOptions{.pixel_error = bytes < (uint64_t{1} << 40) ? 2.0 : 12.0};
  options.cut->most_held_bytes = bytes;
  return options;
}

TEST_F(SurfaceLevelsTest, aClosedSurfaceHasNoCracksWhereLevelsMeet) {
  for (const double bumps : {0.0, 1.5}) {
    const auto source = ball({80, 80, 80}, bumps);
    Pyramid pyramid(*source, 4, true, Spreads::kKept, 8);
    // The eye is near one side of the inside: the far wall is drawn coarser than the near one.
    const auto session = sessionOf(pyramid, surface(30), true);
    for (const Vec3d toward : {Vec3d{0, 0.1, 0.2}, {0.9, 1, 0.1}, {0.2, 0.8, 1}})
      for (const uint64_t bytes : {uint64_t{1} << 40, uint64_t{1} << 19}) {
        const auto [picture, report] = draw(*session, fromInside(source->layout(), toward, bytes));
        EXPECT_GE(report.cut->levels.size(), 2U);
        EXPECT_EQ(holesIn(picture), 0) << toward.x << ", bumps " << bumps << ", bytes " << bytes;
      }
  }
}

// The surfaces of two levels lie apart where they meet: rays would pass both there, or neither. All
// rays from inside pass a closed surface once. Shares of it miss that by a little at faces, and by
// more only where a face's edge meets the surface.
TEST_F(SurfaceLevelsTest, aTranslucentSurfaceIsMetOnceWhereLevelsMeet) {
  constexpr double kOpacity = 0.5;
  const auto source = ball();
  Pyramid pyramid(*source, 4, true, Spreads::kKept, 16);
  const auto session = sessionOf(pyramid, surface(30, kOpacity), true);
  int64_t apart = 0, far_apart = 0, rays = 0;
  for (const Vec3d toward : {Vec3d{0, 0.1, 0.2}, {0.9, 1, 0.1}, {0.2, 0.8, 1}})
    for (const uint64_t bytes : {uint64_t{1} << 40, uint64_t{1} << 19}) {
      const auto [picture, report] = draw(*session, fromInside(source->layout(), toward, bytes));
      EXPECT_GE(report.cut->levels.size(), 2U);
      for (size_t i = 3; i < picture.rgba.size(); i += 4, ++rays) {
        const double clear = 1 - std::min(double{picture.rgba[i]}, 0.999);
        const double times = std::log(clear) / std::log(1 - kOpacity);
        apart += std::abs(times - 1) > 0.25 ? 1 : 0;
        far_apart += std::abs(times - 1) > 0.5 ? 1 : 0;
      }
    }
  EXPECT_LE(apart, 20) << "of " << rays;
  EXPECT_LE(far_apart, 12) << "of " << rays;
}

// Values that rise evenly have the same surfaces on all levels, but at the border of the volume.
// The medium around them looks the same everywhere: a cut's picture is that of level 0, if what
// lies in front of a surface in one block is in front of it in all.
TEST_F(SurfaceLevelsTest, aSurfaceLiesAtItsPlaceInAMediumWhereLevelsMeet) {
  const auto source =
      makeMemorySource<float>(Vec3i{96, 96, 96}, [](int64_t x, int64_t y, int64_t z) {
        return static_cast<float>(x) + 0.7F * static_cast<float>(y) - 0.4F * static_cast<float>(z);
      });
  TransferFunction transfer;
  transfer.colors = {{-40, {0.1, 0.1, 1}}, {200, {0.1, 0.1, 1}}};
  FrameOptions options = obliqueView(Projection::kPerspective, {160, 160});
  options.camera.zoom = 1.5;
  options.crop = Box3{{12, 12, 12}, {84, 84, 84}};
  for (const int64_t block : {8, 16}) {
    Pyramid pyramid(*source, 4, true, Spreads::kNone, block);
    for (const auto& [first, second, medium] :
         {std::array{0.5, 0.4, 0.1}, {0.5, 1.0, 0.1}, {1.0, 0.4, 0.5}}) {
      transfer.opacities = {{-40, medium}, {200, medium}};
      transfer.surfaces = {{40, first, {1, 1, 1}}, {75, second, {1, 0.5, 0}}};
      const auto session = sessionOf(pyramid, transfer);
      options.cut = CutOptions{.pixel_error = 0.01};
      const FloatPicture fine = draw(*session, options).picture;
      EXPECT_GT(shownShare(fine), 0.3);
      for (const uint64_t bytes : {uint64_t{300'000}, uint64_t{900'000}}) {
        options.cut->most_held_bytes = bytes;
        const auto [mixed, report] = draw(*session, options);
        EXPECT_GE(report.cut->levels.size(), 2U);
        EXPECT_TRUE(within(1, mixed, fine)) << "block " << block << ", bytes " << bytes
                                            << ", opacities " << first << ", " << second;
      }
    }
  }
}

TEST_F(SurfaceLevelsTest, blocksThatNoneCrossesAreNotDrawn) {
  const auto source = ball();
  Pyramid pyramid(*source, 3, true, Spreads::kKept);
  const VisibleBlocksPtr blocks = chosen(pyramid, surface(10), viewOfLevel(1));
  ASSERT_FALSE(blocks->blocks.empty());
  for (const ObjectBlock& block : blocks->blocks) {
    EXPECT_EQ(block.name.level, 1);
    // The surface and the four coarse voxels around it that its slices look at.
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(block.cells.hi[a], kBallMiddle[a] - 20);
      EXPECT_LE(block.cells.lo[a], kBallMiddle[a] + 20);
    }
  }
  EXPECT_EQ(blocks->cut->thin_blocks, 0);
}

TEST_F(SurfaceLevelsTest, theFinestLevelIsDrawnAsOfAVolumeOfOneLevel) {
  const auto source = ball();
  Pyramid pyramid(*source, 3, true, Spreads::kKept);
  EXPECT_FALSE(
      drawsCut(pyramid.step, CutOptions{.level = 0}, Mode::kComposite, surface(kBallRadius)));
  EXPECT_TRUE(
      drawsCut(pyramid.step, CutOptions{.level = 1}, Mode::kComposite, surface(kBallRadius)));
  EXPECT_TRUE(drawsCut(pyramid.step, CutOptions{}, Mode::kComposite, surface(kBallRadius)));
}

// Texels of two voxels are made from level 1.
TEST_F(SurfaceLevelsTest, castTheShadowsOfTheirArea) {
  const auto source = ball({160, 160, 160});
  const Pyramid pyramid(*source, 2, true, Spreads::kKept);
  const Look look = makeLook(pyramid.step, surface(kBallRadius, 0.3), Mode::kComposite);
  const double area = 4 * std::numbers::pi * kBallRadius * kBallRadius;
  WorkerPool pool(2);
  for (const MatterFrom from : {MatterFrom::kFinest, MatterFrom::kLevels}) {
    const CoarseExtinction matter = coarseExtinction(pyramid.step, look, from, pool, {});
    ASSERT_EQ(matter.grid.voxels, (Vec3i{2, 2, 2}));
    double sum = 0;
    for (const float extinction : matter.per_length) sum += 8 * extinction;
    EXPECT_NEAR(sum, -std::log(0.7) * area, 0.04 * area);
  }
}

// The shadows of a thin sheet, which the levels have wide and weak.
TEST_F(SurfaceLevelsTest, ofTheFinestLevelAloneAreLitAsOfAVolumeOfOneLevel) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{90, 90, 90},
      [](int64_t x, int64_t y, int64_t z) { return z == 60 || x + y == 80 ? 200.0 : 20.0; });
  Pyramid pyramid(*source, 3, true, Spreads::kKept, 16);
  FrameOptions options = obliqueView(Projection::kOrtho, {72, 64});
  options.lighting.shadows = 1;
  options.lighting.occlusion = 1;
  const auto [alone, alone_report] = draw(*sessionOf(pyramid, surface(100), true), options);
  options.cut = CutOptions{.pixel_error = 0.01};
  const auto session = sessionOf(pyramid, surface(100), true);
  const auto [finest, finest_report] = draw(*session, options);
  ASSERT_EQ(finest_report.cut->levels.size(), 1U);
  EXPECT_LT(compare(finest, alone).max_255, 1);
  // A coarser picture between takes nothing from it.
  options.cut->pixel_error = 8;
  const auto [coarse, coarse_report] = draw(*session, options);
  EXPECT_GT(coarse_report.cut->levels.front().level, 0);
  options.cut->pixel_error = 0.01;
  EXPECT_LT(compare(draw(*session, options).picture, alone).max_255, 1);
}

// Reading all of the finest level is too much for the light of a part of a volume, and of a volume
// that is larger than the blocks of a picture may be.
TEST_F(SurfaceLevelsTest, areLitFromTheFinestLevelIfAllOfItIsDrawn) {
  VolumeLayout layout;
  layout.dims = {100, 100, 100};
  layout.type = VoxelType::kU16;
  VisibleBlocks blocks;
  FrameOptions options;
  EXPECT_TRUE(lightsFromFinest(blocks, options, layout)) << "of one level";
  options.cut = CutOptions{.most_held_bytes = 2'000'000};
  blocks.cut.emplace().levels.resize(1);
  EXPECT_TRUE(lightsFromFinest(blocks, options, layout));
  options.cut->most_held_bytes = 1'999'999;
  EXPECT_FALSE(lightsFromFinest(blocks, options, layout));
  options.cut = CutOptions{};
  options.crop = Box3{{0, 0, 0}, {9, 9, 9}};
  EXPECT_FALSE(lightsFromFinest(blocks, options, layout));
  options.crop.reset();
  options.time_limit_s = 1;
  EXPECT_FALSE(lightsFromFinest(blocks, options, layout));
  options.time_limit_s.reset();
  blocks.cut->levels.resize(2);
  blocks.cut->levels.back().level = 1;
  EXPECT_FALSE(lightsFromFinest(blocks, options, layout));
}

// A bright sheet of one voxel: the means of level 3 stay below the surface's value.
TEST_F(SurfaceLevelsTest, thinSheetsAreCountedAndKept) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{65, 65, 65}, [](int64_t, int64_t, int64_t z) { return z == 30 ? 200.0 : 20.0; });
  Pyramid pyramid(*source, 4, true, Spreads::kKept, 8);
  const auto session = sessionOf(pyramid, surface(100), true);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 64});
  options.cut = CutOptions{.pixel_error = 16};
  const auto [coarse, coarse_report] = draw(*session, options);
  EXPECT_EQ(shownShare(coarse), 0);
  EXPECT_GT(coarse_report.cut->thin_blocks, 0);
  options.cut->keeps_thin = true;
  const auto [kept, kept_report] = draw(*session, options);
  EXPECT_GE(shownShare(kept), 0.2);
  EXPECT_EQ(kept_report.cut->thin_blocks, 0);
}

}  // namespace
}  // namespace sluice
