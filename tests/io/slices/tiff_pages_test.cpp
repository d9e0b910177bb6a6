// TIFF files that describe their pages, and how much is read of them.
#include <gmock/gmock.h>

#include <fstream>

#include "io/open_volume.h"
#include "io/slices/slice_stack.h"
#include "io/slices/tiff/tiff_description.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "tests/io/python_volumes.h"

namespace sluice {
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

TEST(TiffDescription, lengthsThatAreNoneAreWarnedOf) {
  EXPECT_THAT(
      parseTiffDescription("ImageJ=1.53t\nimages=3\nslices=3\nunit=um\nspacing=nan\n", 3, 1, 1)
          .notes,
      testing::ElementsAre(HasSubstr("a spacing of nan, which is no length: 1 is used")));
  EXPECT_THAT(
      parseTiffDescription(
          "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"4\" SizeY=\"4\" SizeZ=\"2\" "
          "SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"-2\" PhysicalSizeZ=\"1\"/></Image></OME>",
          2, 0, 0)
          .notes,
      testing::ElementsAre(HasSubstr("a PhysicalSizeX of -2, which is no length")));
}

TEST(TiffDescription, aShapeThatDoesNotFitThePagesIsWarnedOf) {
  const auto notes = [](const char* text, int64_t pages) {
    return parseTiffDescription(text, pages, 0, 0).notes;
  };
  EXPECT_THAT(notes(R"({"shape": [2, 3, 20, 30]})", 7),
              testing::ElementsAre(HasSubstr("gives 6 pages, as 2 x 3; the file has 7")));
  EXPECT_THAT(notes(R"({"shape": [2, 3, 20, 30], "axes": "TTYX"})", 6),
              testing::ElementsAre(HasSubstr("does not tell")));
  for (const char* text : {R"({"shape": [20, 30]})", R"({"shape": [1, 20, 30]})", R"({"shape": 3})",
                           R"({"shape": [20, 30, 3], "axes": "YXS"})", R"({"shape": [-1, 2, 3]})",
                           R"({"shape")", "{}", R"({"shape": [], "axes": ""})"})
    EXPECT_THAT(notes(text, 1), testing::IsEmpty()) << text;
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

TEST(TiffDescription, thatDoesNotFitGivesSlicesAndANote) {
  const PageOrder imagej = parseTiffDescription("ImageJ=1\nslices=4\nchannels=3\n", 5, 0, 0);
  EXPECT_EQ(imagej.slices, 5);
  EXPECT_THAT(imagej.notes, testing::ElementsAre(HasSubstr("the file has 5 pages")));
  const PageOrder ome = parseTiffDescription(
      "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"4\" SizeC=\"1\" "
      "SizeT=\"1\"/></Image></OME>",
      5, 0, 0);
  EXPECT_EQ(ome.slices, 5);
  EXPECT_THAT(ome.notes, testing::ElementsAre(HasSubstr("its own 5 pages are read as slices")));
  EXPECT_THAT(parseTiffDescription("<OME><Pixels", 2, 0, 0).notes,
              testing::ElementsAre(HasSubstr("its OME description")));
  for (const char* nothing :
       {"", "a microscope", "<OME", "ImageJ=", "<OME><Pixels", "ImageJ=1\nimages=x"}) {
    EXPECT_EQ(parseTiffDescription(nothing, 1, 0, 0).slices, 1) << nothing;
    EXPECT_EQ(parseTiffDescription(nothing, 1, 0, 0).spacing, (Vec3d{1, 1, 1})) << nothing;
  }
}

TEST(TiffDescription, lengthsInSeveralUnitsBecomeThatOfX) {
  const PageOrder imagej = parseTiffDescription(
      "ImageJ=1\nslices=4\nunit=micron\nyunit=nm\nzunit=mm\nspacing=0.002\n", 4, 2, 0.001);
  EXPECT_EQ(imagej.unit, "micrometer");
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(imagej.spacing[a], (Vec3d{0.5, 1, 2})[a], 1e-12);
  const PageOrder ome = parseTiffDescription(
      "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"4\" SizeC=\"1\" SizeT=\"1\" "
      "PhysicalSizeX=\"0.5\" PhysicalSizeY=\"1000\" PhysicalSizeYUnit=\"nm\" "
      "PhysicalSizeZ=\"0.002\" PhysicalSizeZUnit=\"mm\"/></Image></OME>",
      4, 0, 0);
  EXPECT_EQ(ome.unit, "micrometer");
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(ome.spacing[a], (Vec3d{0.5, 1, 2})[a], 1e-12);
}

PageOrder ome(const std::string& sizes, const std::string& planes, int64_t slices = 3) {
  return parseTiffDescription(
      fmt::format("<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"{}\" SizeC=\"1\" "
                  "SizeT=\"1\" {}>{}</Pixels></Image></OME>",
                  slices, sizes, planes),
      slices, 0, 0);
}

// The planes of a channel, each with its PositionZ.
std::string planesAt(const std::vector<double>& depths, const std::string& more) {
  std::string planes;
  for (size_t z = 0; z < depths.size(); ++z)
    planes += fmt::format("<Plane TheZ=\"{}\" TheC=\"0\" TheT=\"0\" PositionZ=\"{}\" {}/>", z,
                          depths[z], more);
  return planes;
}

void expectNear(Vec3d found, Vec3d expected) {
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], expected[a], 1e-9) << a;
}

constexpr const char* kInMicrometers =
    "PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"2\"";

TEST(TiffDescription, theFirstPlaneOfAnOmeDescriptionGivesThePlace) {
  const std::string units = "PositionXUnit=\"mm\" PositionYUnit=\"\u00b5m\" PositionZUnit=\"nm\"";
  const std::string other = "<Plane TheZ=\"0\" TheC=\"0\" TheT=\"1\" PositionX=\"9\"/>";
  const PageOrder order =
      ome(kInMicrometers,
          other + planesAt({7000, 9000, 11000}, "PositionX=\"-1.5\" PositionY=\"30\" " + units));
  expectNear(order.origin, {-1500, 30, 7});
  EXPECT_EQ(order.place_fault, "");
  expectNear(ome(kInMicrometers, "").origin, {0, 0, 0});
}

TEST(TiffDescription, positionsWithoutALengthAreNotUsedAndThatIsSaid) {
  // Without a unit, a position counts in the stage's own frame.
  const PageOrder frame = ome(kInMicrometers, planesAt({1, 3, 5}, "PositionX=\"4\""));
  expectNear(frame.origin, {0, 0, 0});
  EXPECT_THAT(frame.place_fault, HasSubstr("PositionX is in the unit 'reference frame'"));
  const std::string z_unit = "PositionZUnit=\"\u00b5m\"";
  const PageOrder falling = ome(kInMicrometers, planesAt({5, 3, 1}, z_unit));
  expectNear(falling.origin, {0, 0, 0});
  EXPECT_THAT(falling.place_fault, HasSubstr("falls from slice to slice"));
  const PageOrder far = ome(kInMicrometers, planesAt({1e300, 1e300, 1e300}, z_unit));
  EXPECT_THAT(far.place_fault, HasSubstr("beyond"));
  EXPECT_EQ(ome(kInMicrometers, planesAt({0, 0, 0}, "PositionX=\"0\"")).place_fault, "");
}

TEST(TiffDescription, aMissingDistanceOfSlicesFollowsFromThePlanesOrIsSaid) {
  const std::string flat = "PhysicalSizeX=\"0.5\"", unit = "PositionZUnit=\"nm\"";
  const PageOrder even = ome(flat, planesAt({-500, 1000, 2500}, unit));
  expectNear(even.spacing, {0.5, 0.5, 1.5});
  EXPECT_EQ(even.spacing_fault, "");
  expectNear(ome(flat, planesAt({2500, 1000, -500}, unit)).spacing, {0.5, 0.5, 1.5});
  for (const std::string& planes :
       {std::string(), planesAt({0, 1000}, unit), planesAt({0, 0, 0}, unit),
        planesAt({0, 1000, 9000}, unit), planesAt({0, 1000, 2000}, "")}) {
    const PageOrder guess = ome(flat, planes);
    expectNear(guess.spacing, {0.5, 0.5, 1});
    EXPECT_THAT(guess.spacing_fault, HasSubstr("taken to be 1 micrometer apart")) << planes;
  }
  EXPECT_EQ(ome(flat, "", 1).spacing_fault, "");
  EXPECT_EQ(ome(kInMicrometers, "").spacing_fault, "");
}

TEST(TiffDescription, imageJNamesThePixelAtTheOrigin) {
  const std::string said = "ImageJ=1\nslices=4\nxorigin=10\nyorigin=-4\nzorigin=1.5\n";
  const PageOrder order = parseTiffDescription(said + "unit=um\nspacing=2\n", 4, 2, 4);
  expectNear(order.spacing, {0.5, 0.25, 2});
  expectNear(order.origin, {-5, 1, -3});
  // Pixels without a unit.
  expectNear(parseTiffDescription(said, 4, 2, 2).origin, {-10, 4, -1.5});
  const PageOrder apart = parseTiffDescription(said + "spacing=3\n", 4, 0, 0);
  expectNear(apart.spacing, {1, 1, 3});
  expectNear(apart.origin, {-10, 4, -4.5});
  EXPECT_EQ(apart.unit, "");
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
  expectNear(openVolume(file)->layout().origin, {40, 0.5, 0});
  expectNear(openVolume(file, {.spacing = Vec3d{5, 5, 20}})->layout().origin, {400, 5, 0});
  // A stage that drifts is no obstacle to a series.
  const auto series = openVolume({file, stage("q.ome.tif", 900)});
  EXPECT_EQ(series->layout().time_steps, 2);
  EXPECT_NO_THROW(allSteps(*series));
  const auto plain =
      openVolume(write("i.tif", "imagej=True, metadata=dict(axes='ZYX', spacing=3)"));
  expectNear(plain->layout().spacing, {1, 1, 3});
  EXPECT_FALSE(plain->layout().tells_place);
  EXPECT_TRUE(series->layout().tells_place);
  EXPECT_EQ(plain->layout().place_fault, "");
  EXPECT_EQ(series->layout().place_fault, "");
}

// A name in a message is one line.
TEST(TiffDescription, namesOfChannelsArePrintable) {
  const PageOrder order = parseTiffDescription(
      "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"1\" SizeC=\"2\" SizeT=\"1\">"
      "<Channel Name=\"a&#10;b\"/><Channel Name=\"\u03b1-tubulin\"/></Pixels></Image></OME>",
      2, 0, 0);
  EXPECT_THAT(order.channel_names, testing::ElementsAre("a?b", "\u03b1-tubulin"));
}

TEST(TiffDescription, ofASetNamesItsFilesOnceEach) {
  const std::string front =
      "<OME><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\">";
  const auto block = [](int z, int page, const char* file) {
    return fmt::format(
        "<TiffData FirstZ=\"{}\" IFD=\"{}\"><UUID FileName=\"{}\">u</UUID></TiffData>", z, page,
        file);
  };
  const std::string back = "</Pixels></OME>";
  const PageOrder order =
      parseTiffDescription(front + block(1, 7, "a.tif") + block(0, 0, "b.tif") + back, 1, 0, 0);
  EXPECT_THAT(order.files, testing::ElementsAre("a.tif", "b.tif"));
  EXPECT_EQ(order.place(0), (PagePlace{1, 0}));
  EXPECT_EQ(order.place(1), (PagePlace{0, 7}));
  // A file that was renamed is no set.
  const PageOrder renamed =
      parseTiffDescription(front + block(0, 0, "a.tif") + block(1, 1, "a.tif") + back, 2, 0, 0);
  EXPECT_THAT(renamed.files, testing::IsEmpty());
  EXPECT_EQ(renamed.slices, 2);
  // A plane without a page; more planes than anybody has.
  for (const std::string& wrong : {front + block(0, 0, "a.tif") + block(0, 0, "b.tif") + back,
                                   "<OME><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"90000000\">" +
                                       block(0, 0, "a.tif") + block(1, 0, "b.tif") + back}) {
    const PageOrder plain = parseTiffDescription(wrong, 3, 0, 0);
    EXPECT_EQ(plain.slices, 3);
    EXPECT_THAT(plain.files, testing::IsEmpty());
    EXPECT_EQ(plain.notes.size(), 1U);
  }
}

TEST(TiffDescription, blocksSayWhereEachPlaneIs) {
  const std::string front =
      "<OME><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"2\" SizeC=\"2\" SizeT=\"1\">";
  const PageOrder order = parseTiffDescription(
      front +
          "<TiffData FirstZ=\"0\" FirstC=\"1\" IFD=\"0\" PlaneCount=\"2\"/>"
          "<TiffData FirstZ=\"0\" FirstC=\"0\" IFD=\"2\" PlaneCount=\"2\"/></Pixels></OME>",
      4, 0, 0);
  EXPECT_EQ(order.place(order.plane(0, 0, 0)), (PagePlace{0, 2}));
  EXPECT_EQ(order.place(order.plane(0, 1, 1)), (PagePlace{0, 1}));
  for (const char* wrong :
       {"<TiffData IFD=\"9\"/>", "<TiffData FirstZ=\"2\" IFD=\"0\"/>", "<TiffData IFD=\"-1\"/>",
        "<TiffData IFD=\"1\"/>", "<TiffData IFD=\"0\" PlaneCount=\"9\"/>"}) {
    const PageOrder plain = parseTiffDescription(front + wrong + "</Pixels></OME>", 4, 0, 0);
    EXPECT_EQ(plain.slices, 4) << wrong;
    EXPECT_EQ(plain.notes.size(), 1U) << wrong;
  }
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
}  // namespace sluice
