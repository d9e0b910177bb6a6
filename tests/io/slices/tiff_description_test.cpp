// What TIFF files say of their pages: ImageJ, OME and tifffile.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "io/slices/tiff/tiff_description.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// tifffile writes an array of three axes as channels unless they have names.
TEST(TiffDescription, moreChannelsThanImageJShowsAreSlices) {
  const auto parse = [](int64_t channels) {
    return parseTiffDescription(fmt::format("ImageJ=1.11a\nimages={0}\nchannels={0}\n"
                                            "hyperstack=true\nmode=grayscale\n",
                                            channels),
                                channels, 1, 1);
  };
  const PageOrder many = parse(256);
  EXPECT_EQ(many.slices, 256);
  EXPECT_EQ(many.channels, 1);
  EXPECT_EQ(many.slice_step, 1);
  EXPECT_THAT(many.notes, testing::ElementsAre(HasSubstr("256 channels of one slice")));
  const PageOrder few = parse(8);
  EXPECT_EQ(few.channels, 8);
  EXPECT_THAT(few.notes, testing::IsEmpty());
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

// ImageJ writes the micro sign as an escape.
TEST(TiffDescription, timesBetweenFramesAreInUnitsByTheirNames) {
  const auto imageJ = [](const std::string& more) {
    return parseTiffDescription("ImageJ=1.53t\nimages=3\nframes=3\n" + more, 3, 1, 1).times;
  };
  EXPECT_EQ(imageJ("finterval=2.5\n"), (TimeAxis{2.5, 0, "second"}));
  EXPECT_EQ(imageJ("finterval=2\ntunit=\\u00B5s\n"), (TimeAxis{2, 0, "microsecond"}));
  EXPECT_EQ(imageJ("finterval=2\ntunit=fortnight\n"), (TimeAxis{2, 0, "fortnight"}));
  EXPECT_EQ(imageJ("finterval= 2 \ntunit=ms\n"), (TimeAxis{2, 0, "millisecond"}));
  EXPECT_EQ(imageJ(""), std::nullopt);
}

std::string omeOfTimes(int frames, const std::string& more) {
  return fmt::format(
      "<OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"4\" SizeY=\"4\" SizeZ=\"1\" "
      "SizeC=\"1\" SizeT=\" {} \" {}/></Image></OME>",
      frames, more);
}

TEST(TiffDescription, unitsOfTimeHaveTheirNamesInOmeZarr) {
  const auto unitOf = [](const char* unit) {
    const std::string text =
        omeOfTimes(3, fmt::format("TimeIncrement=\" 2.5 \" TimeIncrementUnit=\"{}\"", unit));
    const PageOrder order = parseTiffDescription(text, 3, 0, 0);
    EXPECT_EQ(order.times.value_or(TimeAxis()).step, 2.5) << "blanks around a number";
    return order.times.value_or(TimeAxis()).unit;
  };
  EXPECT_EQ(unitOf(""), "second");
  EXPECT_EQ(unitOf("Zs"), "zettasecond");
  EXPECT_EQ(unitOf("Ms"), "megasecond") << "symbols differ by their case";
  EXPECT_EQ(unitOf("ms"), "millisecond");
  EXPECT_EQ(unitOf("\u03bcs"), "microsecond");
  EXPECT_EQ(unitOf(" min "), "minute");
  EXPECT_EQ(unitOf("Hours"), "hour");
  EXPECT_EQ(unitOf("fortnight"), "fortnight");
}

TEST(TiffDescription, lengthsMayHaveBlanksAround) {
  const std::string text = omeOfTimes(3, "PhysicalSizeX=\" 2 \" PhysicalSizeZ=\"\t3\n\"");
  const PageOrder order = parseTiffDescription(text, 3, 0, 0);
  EXPECT_EQ(order.spacing, (Vec3d{2, 2, 3}));
}

// The unit is kept.
TEST(TiffDescription, timesThatAreNoneAreWarnedOf) {
  for (const char* wrong : {"0", "-2", "nan", "inf", "INF", "abc", "2,5", "1e999"}) {
    const std::string text =
        fmt::format("ImageJ=1.53t\nimages=3\nframes=3\nfinterval={}\ntunit=ms\n", wrong);
    const PageOrder frames = parseTiffDescription(text, 3, 1, 1);
    EXPECT_EQ(frames.times, (TimeAxis{1, 0, "millisecond"})) << wrong;
    EXPECT_THAT(
        frames.notes,
        testing::ElementsAre(HasSubstr(fmt::format(
            "a finterval of {}, which is no time between frames: 1 millisecond is used", wrong))));
    const auto ome = [wrong](int frames) {
      const std::string more = fmt::format("TimeIncrement=\"{}\" TimeIncrementUnit=\"min\"", wrong);
      return parseTiffDescription(omeOfTimes(frames, more), frames, 0, 0);
    };
    EXPECT_EQ(ome(3).times, (TimeAxis{1, 0, "minute"})) << wrong;
    EXPECT_THAT(ome(3).notes,
                testing::Contains(HasSubstr(fmt::format(
                    "its OME description has a TimeIncrement of {}, which is no time between "
                    "frames: 1 minute is used",
                    wrong))));
    EXPECT_THAT(ome(1).notes, testing::Not(testing::Contains(HasSubstr("TimeIncrement"))));
  }
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

}  // namespace
}  // namespace sluice
