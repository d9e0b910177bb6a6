// TIFF files that describe their pages, and how much is read of them.
#include <gmock/gmock.h>

#include <fstream>

#include "io/open_volume.h"
#include "io/slices/slice_picture.h"
#include "io/slices/slice_stack.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "tests/io/python_volumes.h"

namespace sluice::tiff_pages_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A file of make_tiff_pages.py.
struct Case {
  static constexpr const char* kScript = "make_tiff_pages.py";
  static constexpr const char* kModules = "numpy, tifffile";

  std::string name;
  Vec3i dims;
  int64_t steps = 1, channels = 1;
  Vec3d spacing;
  std::string unit;

  friend std::istream& operator>>(std::istream& line, Case& c) {
    return line >> c.name >> c.dims.x >> c.dims.y >> c.dims.z >> c.steps >> c.channels >>
           c.spacing.x >> c.spacing.y >> c.spacing.z >> c.unit;
  }
};

using TiffPages = PythonVolumesTest<Case>;

TEST_F(TiffPages, areSlicesChannelsAndStepsAsTheirDescriptionSays) {
  ASSERT_EQ(cases_.size(), 23U);
  for (const Case& c : cases_) {
    SCOPED_TRACE(c.name);
    const std::string path = pathOf(c.name + ".tif").string();
    const auto source = openVolume(path, {.channel = c.channels - 1});
    const VolumeLayout& layout = source->layout();
    EXPECT_EQ(layout.dims, c.dims);
    EXPECT_EQ(layout.time_steps, c.steps);
    EXPECT_EQ(layout.channels, c.channels);
    EXPECT_EQ(layout.channel, c.channels - 1);
    EXPECT_EQ(layout.unit, c.unit == "-" ? "" : c.unit);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(layout.spacing[a], c.spacing[a], 1e-6 * c.spacing[a]);
    EXPECT_THAT(layout.notes, testing::IsEmpty());
    EXPECT_TRUE(allSteps(*source) == voxelsOf(c.name));
    expectBoxesAreParts(*source, voxelsOf(c.name));
  }
}

TEST_F(TiffPages, aShapeWithoutAxesAndNoDataOfIntegersAreWarnedOf) {
  const VolumeLayout unnamed = openVolume(pathOf("shaped-unnamed.tif").string())->layout();
  EXPECT_EQ(unnamed.dims, (Vec3i{30, 20, 6}));
  EXPECT_THAT(unnamed.notes,
              testing::ElementsAre(HasSubstr("gives 6 pages, as 2 x 3, but does not tell")));
  const auto integers = openVolume(pathOf("no-data-integers.tif").string());
  EXPECT_TRUE(allSteps(*integers) == voxelsOf("no-data-integers"));
  EXPECT_THAT(integers->layout().notes,
              testing::ElementsAre(AllOf(HasSubstr("the value 7 stand for missing values"),
                                         HasSubstr("(GDAL_NODATA)"))));
}

TEST_F(TiffPages, valuesAreScaledAsTheMetadataOfGdalSay) {
  const VolumeLayout scaled = openVolume(pathOf("scaled.tif").string())->layout();
  EXPECT_EQ(scaled.value_scale, 0.5);
  EXPECT_EQ(scaled.value_offset, -10);
  EXPECT_THAT(scaled.notes, testing::IsEmpty());
  for (const auto& [name, said] : {std::pair("scaled-by-0.tif", "without the scale 0 and the"),
                                   std::pair("scaled-white.tif", "without the scale 0.5 and")}) {
    const VolumeLayout stored = openVolume(pathOf(name).string())->layout();
    EXPECT_EQ(stored.value_scale, 1) << name;
    EXPECT_EQ(stored.value_offset, 0) << name;
    EXPECT_THAT(stored.notes, testing::ElementsAre(HasSubstr(said))) << name;
  }
  EXPECT_THAT(errorOf([] {
                openVolume({pathOf("one-a.tif").string(), pathOf("one-b.tif").string()});
              }),
              AllOf(HasSubstr("one-b.tif: values are scaled by 0.25 + -10, expected 0.5 + -10"),
                    HasSubstr("as in "), HasSubstr("one-a.tif")));
}

TEST_F(TiffPages, theFirstChannelIsReadWhereNoneIsChosenAndANoteSaysSo) {
  const auto source = openVolume(pathOf("ome-zct.tif").string());
  EXPECT_EQ(source->layout().channel, 0);
  ASSERT_EQ(source->layout().notes.size(), 1U);
  EXPECT_THAT(source->layout().notes[0],
              AllOf(HasSubstr("channel 0 (stain 0) of 4"), HasSubstr("3 (stain 3)")));
  EXPECT_NE(source->identity(),
            openVolume(pathOf("ome-zct.tif").string(), {.channel = 1})->identity());
  EXPECT_THAT(errorOf([&] { openVolume(pathOf("ome-zct.tif").string(), {.channel = 4}); }),
              HasSubstr("has 4 channels"));
}

TEST(TiffPage, thatCannotBeReadNamesTheReasonAfterAColon) {
  const TempFolder folder;
  const std::string file = (folder / "a.tif").string();
  writeFile(file, std::string("II*\0\x10\0\0\0", 8));
  EXPECT_THAT(errorOf([&] { openVolume(file); }),
              testing::StartsWith(file + ": no readable TIFF: "));
}

TEST_F(TiffPages, whatIsCutOffIsAnError) {
  const std::string bytes = readFile(pathOf("imagej-one-table.tif"));
  const TempFolder folder;
  writeFile(folder / "cut.tif", std::string_view(bytes).substr(0, bytes.size() - 100));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "cut.tif").string()); }),
              HasSubstr("names 20 images of 1200 bytes"));
}

TEST_F(TiffPages, withReducedImagesHaveCoarserLevels) {
  struct Expected {
    const char* name;
    std::vector<Vec3i> dims;
    std::vector<double> offsets;
    const char* note;
  };
  for (const Expected& e :
       {Expected{
            "levels-means", {{64, 48, 9}, {32, 24, 9}, {16, 12, 9}}, {0.5, 1.5}, "common corner"},
        Expected{
            "levels-strided", {{61, 47, 9}, {31, 24, 9}, {16, 12, 9}}, {0, 0}, "common centre"}}) {
    SCOPED_TRACE(e.name);
    const auto source = openVolume(pathOf(std::string(e.name) + ".tif").string());
    const std::span<const CoarserLevel> levels = coarserLevels(*source);
    ASSERT_EQ(levels.size(), 2U);
    EXPECT_EQ(source->layout().levels, 3);
    EXPECT_EQ(source->layout().spacing, (Vec3d{0.5, 0.5, 2}));
    EXPECT_THAT(source->layout().notes, testing::ElementsAre(HasSubstr(e.note)));
    source->holdAtMost(1 << 20);
    for (size_t i = 0; i < 3; ++i) {
      VolumeSource& level = i == 0 ? *source : *levels[i - 1].source;
      EXPECT_EQ(level.layout().dims, e.dims[i]);
      const std::string voxels = voxelsOf(fmt::format("{}-{}", e.name, i));
      EXPECT_TRUE(allSteps(level) == voxels) << i;
      expectBoxesAreParts(level, voxels);
      if (i == 0) continue;
      const double scale = i == 1 ? 2 : 4, offset = e.offsets[i - 1];
      EXPECT_EQ(levels[i - 1].placement, (LevelPlacement{{scale, scale, 1}, {offset, offset, 0}}));
    }
  }
}

// Threads open a picture by themselves, and with little memory again and again.
TEST_F(TiffPages, openedAgainTheirTablesAreKnownUnlessTheFileIsAnother) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "a.tif";
  std::filesystem::copy_file(pathOf("ome-zct.tif"), file);
  const auto first = openSlicePicture(file);
  const auto again = openSlicePicture(file, first->tables());
  EXPECT_GT(first->format().pages, 20);
  EXPECT_LT(again->storedBytesRead(), first->storedBytesRead() / 10);
  const auto rowsOf = [&](SlicePicture& picture, int64_t page) {
    const PictureFormat& format = picture.format();
    std::string rows(static_cast<size_t>(format.width * format.height) * bytesPerVoxel(format.type),
                     ' ');
    picture.readRows(page, 0, 0, format.height, std::as_writable_bytes(std::span(rows)));
    return rows;
  };
  for (const int64_t page : {first->format().pages - 1, int64_t{0}, int64_t{7}})
    EXPECT_TRUE(rowsOf(*again, page) == rowsOf(*first, page)) << page;
  // The table of the last page is read again.
  std::ofstream(file, std::ios::app) << ' ';
  const std::string changed = errorOf([&] { rowsOf(*first, first->format().pages - 1); });
  std::filesystem::copy_file(pathOf("ome-set.tif"), file,
                             std::filesystem::copy_options::overwrite_existing);
  const std::string replaced = errorOf([&] { openSlicePicture(file, first->tables()); });
  for (const std::string& said : {changed, replaced})
    EXPECT_THAT(said, AllOf(HasSubstr("a.tif: changed while it was open"),
                            testing::Not(HasSubstr("damaged"))));
}

TEST_F(TiffPages, ofASetAreThoseOfAllItsFilesWhicheverIsNamed) {
  const auto whole = allSteps(*openVolume(pathOf("ome-set.tif").string(), {.channel = 1}));
  for (const char* file : {"ome-set-1.tif", "ome-set-2.tif"})
    EXPECT_TRUE(allSteps(*openVolume(pathOf(file).string(), {.channel = 1})) == whole) << file;
  const std::vector<std::string> names = {pathOf("ome-set-2.tif").string(),
                                          pathOf("ome-set.tif").string()};
  const auto both = openVolume(names, {.channel = 1});
  EXPECT_TRUE(allSteps(*both) == whole);
  EXPECT_EQ(both->files().size(), 3U);
  EXPECT_THAT(channelNames(*both), testing::ElementsAre("DNA & 0", "DNA & 1"));
}

TEST_F(TiffPages, ofASetThatIsNotWholeAreAnError) {
  const TempFolder folder;
  const auto copy = [&](const std::string& name) {
    std::filesystem::copy_file(pathOf(name), folder / name);
  };
  const auto error = [&](const char* name) {
    return errorOf([&] { openVolume((folder / name).string()); });
  };
  copy("ome-set.tif");
  EXPECT_THAT(error("ome-set.tif"),
              AllOf(HasSubstr("ome-set.tif: "), HasSubstr("names ome-set-1.tif")));
  copy("ome-set-1.tif");
  writeFile(folder / "ome-set-2.tif", readFile(pathOf("ome-companion.tif")));
  EXPECT_THAT(error("ome-set.tif"), AllOf(HasSubstr("ome-set-2.tif: "), HasSubstr("pages")));
  copy("ome-companion.tif");
  EXPECT_THAT(error("ome-companion.tif"),
              HasSubstr("names ome-companion.companion.ome, which is missing"));
  writeFile(folder / "ome-companion.companion.ome", "<OME></OME>");
  EXPECT_THAT(error("ome-companion.tif"), HasSubstr("expected the OME description of the set"));
  std::string elsewhere = readFile(pathOf("ome-companion.tif"));
  for (size_t at = 0; (at = elsewhere.find("ome-companion.c", at)) != std::string::npos; ++at)
    elsewhere.replace(at, 3, "../");
  writeFile(folder / "ome-companion.tif", elsewhere);
  EXPECT_THAT(error("ome-companion.tif"), HasSubstr("expected a name without folders"));
}

// Its compressed bytes, and those behind them, would be read as pixels.
// The last file is named: the others differ from it.
TEST_F(TiffPages, ofASetThatDifferInSizeAreComparedWithTheGivenFile) {
  const TempFolder folder;
  for (const char* name : {"ome-set.tif", "ome-set-1.tif"})
    std::filesystem::copy_file(pathOf(name), folder / name);
  const std::string taller = (folder / "ome-set-2.tif").string();
  const std::string script = fmt::format(
      "import numpy as n, tifffile as t; f = t.TiffFile('{}'); p = f.pages[0]; "
      "t.imwrite('{}', n.zeros((len(f.pages), p.shape[0] + 1, p.shape[1]), p.dtype), "
      "description=p.description, photometric='minisblack', metadata=None)",
      pathOf("ome-set-2.tif").string(), taller);
  ASSERT_EQ(runCommand("/usr/bin/python3 -c \"" + script + "\"").status, 0);
  EXPECT_THAT(errorOf([&] { openVolume(taller); }),
              AllOf(HasSubstr("ome-set.tif: "), HasSubstr("as in " + taller)));
}

TEST(TiffPage, thatLostItsCompressionIsNamed) {
  if (!hasPythonModules("numpy, tifffile")) GTEST_SKIP() << "python3 with tifffile is missing";
  const TempFolder folder;
  const std::string file = (folder / "z.tif").string();
  ASSERT_EQ(
      runCommand("/usr/bin/python3 -c \"import numpy as n, tifffile as t; t.imwrite('" + file +
                 "', n.indices((6, 30, 40)).sum(0).astype('u1'), compression='zlib')\"")
          .status,
      0);
  const std::string sound = readFile(file);
  ASSERT_NO_THROW(openVolume(file));
  // The field 259 of one short number: 8, Adobe's deflate.
  const std::string field("\x03\x01\x03\0\x01\0\0\0\x08\0", 10);
  size_t at = 0;
  for (int page = 1; page <= 6; ++page) {
    at = sound.find(field, at + 1);
    ASSERT_NE(at, std::string::npos);
    std::string damaged = sound;
    damaged[at + 1] = 0x43;
    writeFile(file, damaged);
    EXPECT_THAT(errorOf([&] { openVolume(file); }),
                AllOf(HasSubstr(fmt::format("page {} has fewer bytes", page)),
                      HasSubstr(page == 1 ? "page 2 is compressed" : "page 1 is compressed")));
  }
}

TEST(TiffPage, liesAtItsPlaceInAnySpacing) {
  if (!hasPythonModules("numpy, tifffile")) GTEST_SKIP() << "python3 with tifffile is missing";
  const TempFolder folder;
  const auto write = [&](const std::string& name, const std::string& options) {
    const std::string file = (folder / name).string();
    EXPECT_EQ(runCommand("/usr/bin/python3 -c \"import numpy as n, tifffile as t; t.imwrite('" +
                         file + "', n.zeros((3, 8, 9), 'u1'), " + options + ")\"")
                  .status,
              0);
    return file;
  };
  const auto stage = [&](const char* name, int y) {
    return write(name, fmt::format("ome=True, metadata=dict(axes='ZYX', PhysicalSizeX=.5, "
                                   "PhysicalSizeY=.5, PhysicalSizeZ=2, Plane=dict("
                                   "PositionX=[40]*3, PositionXUnit=['\u00b5m']*3, "
                                   "PositionY=[{}]*3, PositionYUnit=['nm']*3))",
                                   y));
  };
  const std::string file = stage("p.ome.tif", 500);
  EXPECT_LT(length(openVolume(file)->layout().origin - Vec3d{40, 0.5, 0}), 1e-9);
  EXPECT_LT(
      length(openVolume(file, {.spacing = Vec3d{5, 5, 20}})->layout().origin - Vec3d{400, 5, 0}),
      1e-9);
  // A stage that drifts is no obstacle to a series.
  const auto series = openVolume({file, stage("q.ome.tif", 900)});
  EXPECT_EQ(series->layout().time_steps, 2);
  EXPECT_NO_THROW(allSteps(*series));
  const auto plain =
      openVolume(write("i.tif", "imagej=True, metadata=dict(axes='ZYX', spacing=3)"));
  EXPECT_LT(length(plain->layout().spacing - Vec3d{1, 1, 3}), 1e-9);
  EXPECT_FALSE(plain->layout().tells_place);
  EXPECT_TRUE(series->layout().tells_place);
  EXPECT_EQ(plain->layout().place_fault, "");
  EXPECT_EQ(series->layout().place_fault, "");
}

// Every system call that reads, of this process.
int64_t readCalls() {
  std::ifstream file("/proc/self/io");
  std::string key;
  int64_t value = 0;
  while (file >> key >> value)
    if (key == "syscr:") return value;
  return -1;
}

// Rows of strips that lie one behind the other are one read, not one each.
TEST(TiffStrips, areReadWhole) {
  if (readCalls() < 0) GTEST_SKIP() << "/proc/self/io is missing";
  if (!hasPythonModules("numpy, tifffile")) GTEST_SKIP() << "python3 with tifffile is missing";
  const TempFolder folder;
  constexpr int kSlices = 20;
  ASSERT_EQ(runCommand(
                "/usr/bin/python3 -c \"import numpy as n, tifffile as t; "
                "[t.imwrite('" +
                folder.path().string() +
                "/s%02d.tif' % i, n.zeros((512, 512), 'u1'), rowsperstrip=8) for i in range(20)]\"")
                .status,
            0);
  const int64_t before = readCalls();
  const auto source = openSliceFolder(folder.path());
  readAll(*source);
  // 512 rows in 64 strips; some for the tables, which are looked at twice.
  EXPECT_LT(readCalls() - before, kSlices * 14);
}

}  // namespace
}  // namespace sluice::tiff_pages_test
