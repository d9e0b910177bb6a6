#include "io/files/level_places.h"

#include <gmock/gmock.h>

#include "io/open_volume.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/python_volumes.h"

namespace sluice {
namespace {

using testing::Contains;
using testing::HasSubstr;

// An image of make_zarr_levels.py.
struct LevelsCase {
  static constexpr const char* kScript = "make_zarr_levels.py";
  static constexpr const char* kModules = "numpy, zarr";

  std::string name, note;
  size_t levels = 1;
  std::vector<LevelPlacement> places;  // places of the coarser levels

  friend std::istream& operator>>(std::istream& lines, LevelsCase& c) {
    std::string text;
    if (!std::getline(lines, text)) return lines;
    std::istringstream line(text);
    line >> c.name >> c.levels >> c.note;
    c.places.clear();
    for (LevelPlacement p;
         line >> p.scale.x >> p.scale.y >> p.scale.z >> p.offset.x >> p.offset.y >> p.offset.z;)
      c.places.push_back(p);
    return lines;
  }
};

class ZarrLevels : public PythonVolumesTest<LevelsCase> {};

TEST_F(ZarrLevels, areThoseThatFitPlacedWithinAHundredthOfAVoxel) {
  ASSERT_GT(cases_.size(), 15U);
  for (const LevelsCase& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = openVolume(pathOf(c.name).string());
    const std::span<const CoarserLevel> levels = coarserLevels(*source);
    ASSERT_EQ(levels.size() + 1, c.levels) << testing::PrintToString(source->layout().notes);
    ASSERT_EQ(levels.size(), c.places.size());
    EXPECT_EQ(source->layout().levels, static_cast<int64_t>(c.levels));
    for (size_t i = 0; i < levels.size(); ++i)
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(levels[i].placement.scale[a], c.places[i].scale[a], 1e-6) << i << " " << a;
        EXPECT_NEAR(levels[i].placement.offset[a], c.places[i].offset[a], 0.01) << i << " " << a;
      }
    if (c.note == "-")
      EXPECT_EQ(source->layout().notes.size(), 0U);
    else
      EXPECT_THAT(source->layout().notes, Contains(HasSubstr(c.note)));
  }
}

// A level's voxels are those that its folder has, opened by itself.
TEST_F(ZarrLevels, holdTheVoxelsOfTheirFolders) {
  const auto source = openVolume(pathOf("odd-rounded-up").string());
  for (size_t i = 0; i < 2; ++i) {
    const auto alone = openVolume((pathOf("odd-rounded-up") / std::to_string(i + 1)).string());
    VolumeSource& level = *coarserLevels(*source)[i].source;
    EXPECT_EQ(level.layout().dims, alone->layout().dims);
    EXPECT_TRUE(readAll(level) == readAll(*alone));
    EXPECT_EQ(coarserLevels(*alone).size(), 0U);
  }
}

TEST_F(ZarrLevels, stayWithASpacingOfTheUsersOwn) {
  OpenOptions options;
  options.spacing = Vec3d{1, 2, 3};
  const auto source = openVolume(pathOf("translated").string(), options);
  EXPECT_EQ(coarserLevels(*source).size(), 2U);
}

// The budget of the image is shared by all levels, and one level may have all of it.
TEST_F(ZarrLevels, shareTheBudgetOfTheImage) {
  ZarrSource source(pathOf("translated"));
  const uint64_t chunk = 16 * 16 * 16 * 4;
  for (const uint64_t chunks : {4, 80}) {
    source.holdAtMost(chunks * chunk);
    readAll(source);
    for (const CoarserLevel& level : source.levelsAbove()) {
      level.source->holdAtMost(1000 * chunk);  // not the level's own to change
      readAll(*level.source);
      EXPECT_LE(source.heldBytes(), chunks * chunk);
      const uint64_t before = source.storedBytesRead();
      readAll(*level.source);
      if (chunks == 80) {
        EXPECT_EQ(source.storedBytesRead(), before) << "it is kept as a whole";
      }
    }
  }
}

TEST(ZarrLevelFactors, areOfTheScalesOrTheShapes) {
  const auto factor = [](Vec3i finest, Vec3i level) {
    return levelFactor({finest, {}, {}}, {level, {}, {}});
  };
  EXPECT_EQ(factor({64, 63, 65}, {32, 32, 33}), (Vec3d{2, 2, 2}));
  EXPECT_EQ(factor({64, 63, 65}, {32, 31, 32}), (Vec3d{2, 2, 2}));
  EXPECT_EQ(factor({100, 1, 10}, {33, 1, 10}), (Vec3d{3, 1, 1}));
  const Vec3d fine{0.5, 0.5, 2}, coarse{1.5, 1, 2};
  EXPECT_EQ(levelFactor({{9, 9, 9}, fine, {}}, {{3, 4, 9}, coarse, {}}), (Vec3d{3, 2, 1}));
}

}  // namespace
}  // namespace sluice
