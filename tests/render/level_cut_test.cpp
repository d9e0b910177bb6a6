// Cuts through levels of resolution: the blocks that they choose.
#include "src/render/blocks/cut/level_cut.h"
#include "src/render/blocks/cut/cut_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "src/base/error.h"
#include "src/render/camera/index_space.h"
#include "src/render/camera/pixel_sizes.h"
#include "tests/render/level_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

using testing::HasSubstr;

TEST_F(LevelCutTest, theCoarsestLevelWithinThePixelErrorIsChosenWhereTheBlockLies) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 4);
  const VolumeLayout& volume = source->layout();
  FrameOptions options = insideView(volume, {0.2, 0.5, 0.5}, {0.9, 0.6, 0.5});
  options.cut = CutOptions{.pixel_error = 3};
  const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(20, 255), options);
  expectPartition(pyramid, *blocks);
  EXPECT_GE(levelsOf(*blocks).size(), 3U);
  EXPECT_TRUE(blocks->cut->is_final);
  EXPECT_GT(blocks->cut->coarse_share, 0.0);
  EXPECT_LT(blocks->cut->coarse_share, 1.0);
  const View view = viewOf(pyramid, options);
  int wide = 0;
  for (const ObjectBlock& block : blocks->blocks) {
    // Corners of the region that the picture shows, found the plain way.
    const Box3 region = pyramid.layout().regionOf(block.name);
    for (int corner = 0; corner < 8; ++corner) {
      Vec3d at;
      for (int a = 0; a < 3; ++a)
        at[a] = static_cast<double>((corner >> a & 1) != 0 ? region.hi[a] : region.lo[a]);
      const Vec3d from = worldFromIndex(volume, at) - view.eye;
      const double depth = dot(from, view.forward);
      const double half = view.half_height * depth;
      const double aspect = static_cast<double>(view.size.width) / view.size.height;
      const bool is_shown = depth > 0 && std::abs(dot(from, view.up)) < half &&
                            std::abs(dot(from, view.right)) < aspect * half;
      if (!is_shown) continue;
      const double pixel = 2 * half / view.size.height;
      const double voxel = std::pow(2.0, block.name.level);
      if (block.name.level > 0) {
        EXPECT_LE(voxel / pixel, 3 + 1e-9) << "level " << block.name.level;
      }
      wide += 2 * voxel / pixel > 3 ? 1 : 0;
    }
  }
  EXPECT_GT(wide, 20) << "a coarser level would do as well everywhere";
}

// A body that is framed by what shows of it is framed a little differently at another resolution.
TEST_F(LevelCutTest, voxelsOnePixelWideAreDrawnIfTheFramingDiffersALittle) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 4);
  FrameOptions options;
  options.size = {64, 64};
  const View view = viewOf(pyramid, options);
  const PyramidLayout levels = pyramid.step.layout();
  const double level_2_pixels =
      PixelSizes(source->layout(), view)
          .of(levels.level(2), boxOf(levels.finest().dims - Vec3i{1, 1, 1}));
  for (const auto& [excess, level] : {std::pair(1.015, 2), std::pair(1.025, 1)}) {
    options.cut = CutOptions{.pixel_error = level_2_pixels / excess};
    EXPECT_EQ(levelsOf(*chosen(pyramid, opaqueAbove(20, 255), options)), std::set<int32_t>{level});
    EXPECT_EQ(finestLevelShown(pyramid.step, view, *options.cut), level);
  }
}

TEST_F(LevelCutTest, aParallelViewHasOneLevelThatFollowsFromItsPixels) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 4);
  FrameOptions options;
  options.size = {64, 64};
  for (const auto& [pixels, level] :
       {std::pair(0.4, 0), std::pair(1.5, 1), std::pair(3.0, 2), std::pair(100.0, 3)}) {
    options.cut = CutOptions{.pixel_error = 1};
    const double pixel = 2 * viewOf(pyramid, options).half_height / 64;
    options.cut->pixel_error = pixels * 1.6 / pixel;
    const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(20, 255), options);
    expectPartition(pyramid, *blocks);
    EXPECT_EQ(levelsOf(*blocks), std::set<int32_t>{level});
    EXPECT_EQ(finestLevelShown(pyramid.step, viewOf(pyramid, options), *options.cut), level);
    EXPECT_EQ(spacingOfLevel(pyramid.step, level), std::pow(2.0, level));
    EXPECT_EQ(blocks->cut->coarse_share, level == 0 ? 0.0 : 1.0);
  }
}

TEST_F(LevelCutTest, atLevelZeroTheBlocksAreThoseOfTheClassification) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 3);
  FrameOptions options;
  options.crop = Box3{{10, 0, 20}, {100, 90, 80}};
  const VisibleBlocksPtr expected = chosen(pyramid, opaqueAbove(20, 255), options);
  ASSERT_FALSE(expected->cut.has_value()) << "no cut was asked for";
  for (const CutOptions& cut : {CutOptions{.level = 0}, CutOptions{.pixel_error = 1e-3}}) {
    options.cut = cut;
    const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(20, 255), options);
    ASSERT_EQ(blocks->blocks.size(), expected->blocks.size());
    for (size_t i = 0; i < blocks->blocks.size(); ++i) {
      EXPECT_EQ(blocks->blocks[i].name, expected->blocks[i].name);
      EXPECT_EQ(blocks->blocks[i].cells, expected->blocks[i].cells);
      EXPECT_EQ(blocks->blocks[i].kind, expected->blocks[i].kind);
    }
    EXPECT_EQ(blocks->cut->coarse_share, 0.0);
  }
}

TEST_F(LevelCutTest, aBudgetEndsTheRefinementAndWhatLiesInFrontIsFinest) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 4);
  FrameOptions options;  // along -z
  options.cut = CutOptions{.pixel_error = 1e-3};
  const auto bytesOf = [&](const VisibleBlocks& blocks) {
    uint64_t bytes = 0;
    for (const ObjectBlock& block : blocks.blocks)
      bytes += static_cast<uint64_t>(pyramid.layout().storedVoxels(block.name).count());
    return bytes;
  };
  const uint64_t whole = bytesOf(*chosen(pyramid, opaqueAbove(20, 255), options));
  bool was_mixed = false;
  for (const double share : {0.9, 0.5, 0.2, 0.05}) {
    options.cut->most_stored_bytes = static_cast<uint64_t>(share * static_cast<double>(whole));
    const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(20, 255), options);
    expectPartition(pyramid, *blocks);
    EXPECT_LE(bytesOf(*blocks), options.cut->most_stored_bytes);
    EXPECT_FALSE(blocks->cut->is_final);
    const std::set<int32_t> levels = levelsOf(*blocks);
    EXPECT_LE(levels.size(), 2U) << "refined level by level";
    if (levels.size() < 2) continue;
    was_mixed = true;
    // The finer level reaches no deeper than the begin of the coarser one, to a coarse block.
    int64_t finer = INT64_MAX, coarser = 0;
    for (const ObjectBlock& block : blocks->blocks) {
      const Box3 region = pyramid.layout().regionOf(block.name);
      const int64_t middle = (region.lo.z + region.hi.z) / 2;
      if (block.name.level == *levels.begin())
        finer = std::min(finer, middle);
      else
        coarser = std::max(coarser, middle);
    }
    EXPECT_LE(coarser - finer, 2 * pyramid.layout().level(*levels.rbegin()).width.z);
  }
  EXPECT_TRUE(was_mixed);
}

TEST_F(LevelCutTest, viewsOfTheSameCutShareItsBlocks) {
  const auto source = manyBlobs({90, 90, 90});
  Pyramid pyramid(*source, 3);
  WorkerPool pool(2);
  LevelCut cut(pool);
  ChunkNames names;
  Planner planner({{8, 8, 8}, 1, 1 << 12}, pool, names);
  const auto transfer = std::make_shared<const TransferFunction>(opaqueAbove(20, 255));
  const LookPtr look = planner.look(pyramid.step, transfer, Mode::kComposite);
  FrameOptions options;
  const Box3 all = boxOf(Vec3i{89, 89, 89});
  const auto blocksAt = [&](double azimuth_deg, double pixel_error) {
    options.camera.azimuth_deg = azimuth_deg;
    return cut.choose({pyramid.step, look, all, viewOf(pyramid, options),
                       CutOptions{.pixel_error = pixel_error}});
  };
  const VisibleBlocksPtr first = blocksAt(0, 9);
  EXPECT_EQ(levelsOf(*first), std::set<int32_t>{1});
  EXPECT_EQ(blocksAt(40, 9).get(), first.get());
  EXPECT_NE(blocksAt(40, 0.1).get(), first.get());
}

TEST_F(LevelCutTest, levelsWithoutRangesShowWhatTheFinestLevelHas) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 3);
  for (CoarserStep& level : pyramid.step.coarser) level.ranges = nullptr;
  FrameOptions options;
  options.cut = CutOptions{.pixel_error = 1000};
  const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(20, 255), options);
  expectPartition(pyramid, *blocks);
  for (const ObjectBlock& block : blocks->blocks)
    EXPECT_EQ(block.cells, pyramid.layout().regionOf(block.name)) << "not known: may show";
}

// What is drawn of a level with spreads follows from the finest level: all that shows there, and no
// more than interpolation of the level's voxels can carry it.
TEST_F(LevelCutTest, levelsWithSpreadsShowWhereTheFinestLevelDoes) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 4, false, Spreads::kKept);
  FrameOptions options;
  const VisibleBlocksPtr finest = chosen(pyramid, opaqueAbove(90, 255), options);
  for (const int level : {1, 2, 3}) {
    options.cut = CutOptions{.level = level};
    const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(90, 255), options);
    expectPartition(pyramid, *blocks);
    for (const ObjectBlock& object : finest->blocks) {
      // Every cell of it is in one of the boxes.
      int64_t covered = 0;
      for (const ObjectBlock& block : blocks->blocks)
        covered += intersect(block.cells, object.cells).count();
      EXPECT_EQ(covered, object.cells.count());
    }
    for (const ObjectBlock& block : blocks->blocks) {
      // Below it, or below a block beside it.
      const Box3 region = pyramid.layout().regionOf(block.name);
      const Vec3i width = pyramid.layout().of(block.name).width;
      const Box3 near{region.lo - width, region.hi + width};
      EXPECT_TRUE(std::ranges::any_of(finest->blocks, [&](const ObjectBlock& object) {
        return !intersect(object.cells, near).empty();
      }));
    }
  }
}

// Lines one voxel wide, whose means are below the threshold everywhere. At this threshold the
// finest level shows them as wide as a voxel is.
TEST_F(LevelCutTest, aNetOfThinLinesKeepsMostOfItsOpacityAtCoarseLevels) {
  FunctionSource net(functionLayout({104, 104, 104}, VoxelType::kU8), [](int64_t, Vec3i v) {
    const int along = (v.x % 16 == 5) + (v.y % 16 == 6) + (v.z % 16 == 9);
    return along >= 2 ? 200.0 : 0.0;
  });
  Pyramid means(net, 4), spreads(net, 4, false, Spreads::kKept);
  TransferFunction transfer;
  transfer.colors = {{80, {1, 1, 1}}};
  transfer.opacities = {{80 - 1e-6, 0}, {80, 0.2}, {200, 0.2}};
  const auto opacityOf = [](const Drawn& drawn) {
    double sum = 0;
    for (size_t i = 3; i < drawn.picture.rgba.size(); i += 4) sum += drawn.picture.rgba[i];
    return sum;
  };
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.step_vox = 0.25;
  for (const bool with_spreads : {false, true}) {
    Pyramid& pyramid = with_spreads ? spreads : means;
    const auto session = sessionOf(pyramid, transfer);
    options.cut.reset();
    const double finest = opacityOf(draw(*session, options));
    ASSERT_GT(finest, 10);
    for (const int level : {1, 2, 3}) {
      options.cut = CutOptions{.level = level};
      const double kept = opacityOf(draw(*session, options)) / finest;
      if (with_spreads) {
        // A line is half as wide as a voxel of level 1, and blurred the most there.
        EXPECT_GT(kept, level == 1 ? 0.88 : 0.9) << level;
        EXPECT_LT(kept, 1.1) << level;
      } else {
        EXPECT_LT(kept, 0.1) << "a mean alone loses them";
      }
    }
  }
}

// One voxel, also where it lies on a face between blocks and so in the cells of several.
TEST_F(LevelCutTest, oneBrightVoxelIsReportedAndRefinedOnRequest) {
  const int64_t face = 3 * blockLayout({104, 104, 104}, kBlock, 1).cells();
  for (const Vec3i bright : {Vec3i{41, 50, 33}, Vec3i{face, 50, face}}) {
    FunctionSource source(functionLayout({104, 104, 104}, VoxelType::kU8),
                          [&](int64_t, Vec3i v) { return v == bright ? 255.0 : 0.0; });
    Pyramid pyramid(source, 4, false, Spreads::kKept);
    const TransferFunction transfer = opaqueAbove(100, 255, 0.9);
    const auto session = sessionOf(pyramid, transfer);
    const auto opacityOf = [](const Drawn& drawn) {
      float most = 0;
      for (size_t i = 3; i < drawn.picture.rgba.size(); i += 4)
        most = std::max(most, drawn.picture.rgba[i]);
      return most;
    };
    for (const Projection projection : kProjections) {
      FrameOptions options = obliqueView(projection);
      options.size = {280, 260};  // pixels smaller than voxels, so that rays meet it
      options.step_vox = 0.25;
      const float finest = opacityOf(draw(*session, options));
      ASSERT_GT(finest, 0.1);
      options.cut = CutOptions{.pixel_error = 1000};
      const Drawn coarse = draw(*session, options);
      EXPECT_GT(coarse.report.cut->thin_blocks, 0);
      EXPECT_LT(opacityOf(coarse), 0.5 * finest);
      options.cut->keeps_thin = true;
      const Drawn kept = draw(*session, options);
      EXPECT_EQ(kept.report.cut->thin_blocks, 0);
      EXPECT_EQ(kept.report.cut->levels.front().level, 0);
      EXPECT_NEAR(opacityOf(kept), finest, 0.01);
    }
  }
}

// A ball cuts off slivers at the faces of many blocks, which go on in the next ones.
TEST_F(LevelCutTest, aSolidBallHasNoThinParts) {
  FunctionSource ball(functionLayout({104, 104, 104}, VoxelType::kU8), [](int64_t, Vec3i v) {
    return length(toDouble(v) - Vec3d{51, 50, 52}) < 37 ? 200.0 : 0.0;
  });
  Pyramid pyramid(ball, 2, false, Spreads::kKept);
  FrameOptions options;
  for (const std::optional<Box3>& crop :
       {std::optional<Box3>(), std::optional(Box3{{0, 0, 50}, {104, 104, 53}})}) {
    options.crop = crop;
    options.cut = CutOptions{.level = 1};
    const VisibleBlocksPtr blocks = chosen(pyramid, opaqueAbove(100, 255), options);
    EXPECT_EQ(blocks->cut->thin_blocks, 0);
    options.cut = CutOptions{.pixel_error = 1000, .keeps_thin = true};
    EXPECT_EQ(levelsOf(*chosen(pyramid, opaqueAbove(100, 255), options)), std::set<int32_t>{1});
  }
}

// Against the spreads of the level's own source.
TEST_F(LevelCutTest, theReportHasTheSpreadsOfTheVoxelsThatAreShown) {
  const auto source = manyBlobs({120, 101, 95});
  Pyramid pyramid(*source, 3, false, Spreads::kKept);
  const auto session = sessionOf(pyramid, opaqueAbove(0, 255, 0.01));
  FrameOptions options = obliqueView(Projection::kOrtho);
  EXPECT_FALSE(draw(*session, options).report.cut.has_value());
  for (const size_t level : {1, 2}) {
    VolumeSource& spreads = *pyramid.means.levels()[level - 1].spreads;
    const Box3 all = boxOf(spreads.layout().dims);
    std::vector<std::byte> bytes(static_cast<size_t>(all.count()));
    spreads.readRegion(0, all, bytes);
    double largest = 0, sum = 0;
    for (const std::byte spread : bytes) {
      largest = std::max(largest, static_cast<double>(spread));
      sum += static_cast<double>(spread);
    }
    options.cut = CutOptions{.level = static_cast<int>(level)};
    const std::optional<StandingSpread> said = draw(*session, options).report.cut->spread;
    ASSERT_TRUE(said.has_value());
    EXPECT_EQ(said->largest, largest);
    // Blocks share the voxels at their borders.
    EXPECT_NEAR(said->mean, sum / static_cast<double>(bytes.size()), 0.25 * said->mean);
  }
}

TEST_F(LevelCutTest, labelsAreNotDrawnFromMeans) {
  const auto source = manyBlobs({60, 60, 60});
  Pyramid pyramid(*source, 2, false, Spreads::kKept);
  TransferFunction transfer = opaqueAbove(20, 255);
  transfer.labels = true;
  FrameOptions options;
  options.cut = CutOptions{.level = 1};
  EXPECT_THAT(errorOf([&] { chosen(pyramid, transfer, options); }),
              HasSubstr("hold means, which are no labels"));
}

TEST_F(LevelCutTest, aLevelThatIsNotThereIsSaid) {
  const auto source = manyBlobs({60, 60, 60});
  Pyramid pyramid(*source, 2);
  FrameOptions options;
  options.cut = CutOptions{.level = 2};
  EXPECT_THAT(errorOf([&] { chosen(pyramid, opaqueAbove(20, 255), options); }),
              HasSubstr("--level 2: there are 2 levels, counted from 0"));
}

}  // namespace
}  // namespace sluice
