#include "io/headers/nrrd/nrrd_header.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/io/headers/nrrd_headers.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::nrrd_header_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

VolumeDescription parse(const std::string& text) {
  return parseNrrdHeader(text, "v.nrrd");
}

void expectNear(Vec3d actual, Vec3d expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], 1e-12) << axis;
}

TEST(NrrdHeaderTest, readsAPlainHeader) {
  const VolumeDescription d = parse(std::string(kPlainNrrd) + "\nvoxels");
  EXPECT_TRUE(d.layout.dims == kNrrdDims);
  EXPECT_EQ(d.layout.type, VoxelType::kI16);
  EXPECT_EQ(d.byte_order, std::endian::little);
  EXPECT_EQ(d.encoding, Encoding::kRaw);
  EXPECT_EQ(d.data_offset, std::string(kPlainNrrd).size() + 1);
  EXPECT_TRUE(d.files.attached());
}

TEST(NrrdHeaderTest, passesOverCommentsKeyValuesAndUnknownFields) {
  const VolumeDescription d = parse(
      "NRRD0005\r\n# type: double\r\ntype: unsigned short int\r\nkey:=type: double\r\n"
      "a b:=c\r\ncontent: x: y\r\ncenters: cell cell cell\r\nSpace Units: \"mm\"\r\n"
      "dimension: 3\r\nsizes: 5 4 3\r\nlabels: \"a\" \"b\" \"c\"\r\nthicknesses: nan nan 2\r\n"
      "endian: big\r\nencoding: gz\r\nLineSkip: 2\r\nbyte skip: 7\r\n\r\n#");
  EXPECT_EQ(d.layout.type, VoxelType::kU16);
  EXPECT_EQ(d.byte_order, std::endian::big);
  EXPECT_EQ(d.encoding, Encoding::kDeflate);
  EXPECT_EQ(d.line_skip, 2);
  EXPECT_EQ(d.byte_skip, 7);
}

TEST(NrrdHeaderTest, namesFieldsWithoutAMeaning) {
  EXPECT_EQ(parse(headerWith("byte skip", "7")).layout.notes.size(), 0U);
  EXPECT_EQ(parse(headerWith("byte inf", "7")).layout.notes,
            std::vector<std::string>{"v.nrrd: its header has a field without a meaning, which is "
                                     "passed over: 'byteinf'"});
  EXPECT_EQ(parse(headerWith("spbcings", "1 1 2\nEndianness: big")).layout.notes,
            std::vector<std::string>{"v.nrrd: its header has fields without a meaning, which are "
                                     "passed over: 'endianness', 'spbcings'"});
}

TEST(NrrdHeaderTest, knowsTheNamesOfTypes) {
  const std::pair<const char*, VoxelType> cases[] = {
      {"signed char", VoxelType::kI8}, {"int8_t", VoxelType::kI8},
      {"uchar", VoxelType::kU8},       {"unsigned char", VoxelType::kU8},
      {"short", VoxelType::kI16},      {"signed short int", VoxelType::kI16},
      {"ushort", VoxelType::kU16},     {"unsigned short", VoxelType::kU16},
      {"int", VoxelType::kI32},        {"signed int", VoxelType::kI32},
      {"uint32", VoxelType::kU32},     {"unsigned int", VoxelType::kU32},
      {"float", VoxelType::kF32},      {"double", VoxelType::kF64}};
  for (const auto& [text, type] : cases)
    EXPECT_EQ(parse(headerWith("type", text)).layout.type, type) << text;
}

TEST(NrrdHeaderTest, spacingsGiveTheSteps) {
  const VolumeLayout layout = parse(headerWith("spacings", "2 nan -0.5")).layout;
  expectNear(layout.spacing, {2, 1, 0.5});
  expectNear(layout.axes[2], {0, 0, -1});
  EXPECT_THAT(layout.notes,
              testing::ElementsAre(HasSubstr("its spacing along axis 1 is nan"),
                                   HasSubstr("its spacing is 2 x 1 x -0.5: an axis of negative")));
}

// teem's nrrdSpacingCalculate and nrrdOriginCalculate: 5 x 4 x 3 voxels between the ends.
TEST(NrrdHeaderTest, theEndsOfTheAxesGiveTheOrigin) {
  const VolumeLayout cells =
      parse(headerWith("axis mins", "10 -20 30\naxis maxs: 12.5 -12 nan\nspacings: nan 2 3"))
          .layout;
  expectNear(cells.spacing, {0.5, 2, 3});
  expectNear(cells.origin, {10.25, -19, 31.5});
  const VolumeLayout nodes = parse(headerWith("axis mins",
                                              "10 -20 nan\naxis maxs: 12 -14 7\n"
                                              "centerings: node node node"))
                                 .layout;
  expectNear(nodes.spacing, {0.5, 2, 1});
  expectNear(nodes.origin, {10, -20, 0});
  // Ends that fall together give no spacing.
  expectNear(parse(headerWith("axis mins", "0 0 0\naxis maxs: 0 0 0")).layout.spacing, {1, 1, 1});
  // The space has an origin of its own.
  expectNear(
      parse(headerWith("axis mins", "7 7 7\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)"))
          .layout.origin,
      {0, 0, 0});
}

TEST(NrrdHeaderTest, spaceDirectionsAndOriginGiveTheWorld) {
  std::string text = kPlainNrrd;
  text +=
      "space: left-posterior-superior\nspace directions: (0,2,0) ( 0, 0, 3 ) (4,4,0)\n"
      "space origin: (-1.5,2e1,3)\n\n";
  const VolumeLayout layout = parse(text).layout;
  expectNear(layout.spacing, {2, 3, std::sqrt(32.0)});
  expectNear(layout.axes[0], {0, 1, 0});
  expectNear(layout.axes[1], {0, 0, 1});
  expectNear(layout.axes[2], {std::sqrt(0.5), std::sqrt(0.5), 0});
  expectNear(layout.origin, {-1.5, 20, 3});
}

TEST(NrrdHeaderTest, aSpaceOfAPatientIsTheWorldsFrame) {
  const auto frameOf = [](const char* space) {
    return parse(headerWith("space", space)).layout.frame;
  };
  for (const char* ras : {"right-anterior-superior", "RAS", "Right-Anterior-Superior-Time", "RAST"})
    EXPECT_EQ(frameOf(ras), WorldFrame::kRas) << ras;
  for (const char* lps : {"left-posterior-superior", "LPS", "left-posterior-superior-time", "LPST"})
    EXPECT_EQ(frameOf(lps), WorldFrame::kLps) << lps;
  for (const char* none : {"scanner-xyz", "scanner-xyz-time", "3D-right-handed", ""})
    EXPECT_EQ(frameOf(none), WorldFrame::kNone) << none;
}

// The left side in the file must not be shown as the right side.
TEST(NrrdHeaderTest, leftAnteriorSuperiorIsMirroredIntoRightAnteriorSuperior) {
  std::string text = kPlainNrrd;
  text +=
      "space: left-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
      "space origin: (10,20,30)\n\n";
  const VolumeLayout layout = parse(text).layout;
  EXPECT_EQ(layout.frame, WorldFrame::kRas);
  expectNear(layout.axes[0], {-1, 0, 0});
  expectNear(layout.axes[1], {0, 1, 0});
  expectNear(layout.origin, {-10, 20, 30});
}

TEST(NrrdHeaderTest, unitsAreThoseOfTheSpaceOrOfTheFirstAxis) {
  EXPECT_EQ(parse(headerWith("space units", R"("mm" "mm" "mm")")).layout.unit, "millimeter");
  EXPECT_EQ(parse(headerWith("units", R"("um" "um" "um")")).layout.unit, "micrometer");
  EXPECT_EQ(parse(headerWith("units", R"("" "" "")")).layout.unit, "");
  EXPECT_EQ(parse(headerWith("units", "mm")).layout.unit, "");
}

TEST(NrrdHeaderTest, lengthsInSeveralUnitsBecomeThatOfTheFirstAxis) {
  const VolumeLayout of_axes =
      parse(headerWith("units", "\"um\" \"nm\" \"mm\"\nspacings: 1 2000 0.5")).layout;
  EXPECT_EQ(of_axes.unit, "micrometer");
  expectNear(of_axes.spacing, {1, 2, 500});
  // A direction is of the world, whose y has a unit of its own.
  const VolumeLayout of_space =
      parse(headerWith("space units",
                       "\"mm\" \"um\" \"mm\"\nspace: RAS\n"
                       "space directions: (0,500,0) (2,0,0) (0,0,3)\nspace origin: (1,2000,3)"))
          .layout;
  EXPECT_EQ(of_space.unit, "millimeter");
  expectNear(of_space.spacing, {0.5, 2, 3});
  expectNear(of_space.origin, {1, 2, 3});
  // A unit that is not known is left as it is.
  expectNear(parse(headerWith("units", "\"mm\" \"ell\" \"mm\"")).layout.spacing, {1, 1, 1});
}

// The unit of an axis that is not of space is passed over.
TEST(NrrdHeaderTest, theUnitIsThatOfTheFirstAxisOfSpace) {
  const std::string text =
      "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 1 4 3 2\nencoding: raw\n"
      "kinds: scalar domain domain domain\nunits: \"\" \"mm\" \"mm\" \"um\"\n\n";
  const VolumeLayout layout = parse(text).layout;
  EXPECT_EQ(layout.unit, "millimeter");
  expectNear(layout.spacing, {1, 1, 0.001});
}

std::string fourDimensional(const std::string& sizes, const std::string& more) {
  return "NRRD0004\ntype: uchar\ndimension: 4\nsizes: " + sizes + "\nencoding: raw\n" + more + "\n";
}

TEST(NrrdHeaderTest, theSlowestAxisOfFourIsTime) {
  for (const char* more :
       {"", "kinds: domain domain domain time\n", "spacings: 1 1 1 nan\n",
        "space directions: (1,0,0) (0,1,0) (0,0,1) none\n", "kinds: space space space list\n",
        "space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,1)\n"}) {
    const VolumeLayout layout = parse(fourDimensional("5 4 3 2", more)).layout;
    EXPECT_TRUE(layout.dims == kNrrdDims) << more;
    EXPECT_EQ(layout.time_steps, 2) << more;
  }
}

TEST(NrrdHeaderTest, anAxisOfOneElementThatIsNotOfSpaceIsDropped) {
  const VolumeLayout layout =
      parse(fourDimensional("1 5 4 3", "spacings: nan 2 3 4\nkinds: vector space space space\n"))
          .layout;
  EXPECT_TRUE(layout.dims == kNrrdDims);
  expectNear(layout.spacing, {2, 3, 4});
}

TEST(NrrdHeaderTest, rejectsColorsAndVectors) {
  EXPECT_THAT(
      errorOf([] { parse(fourDimensional("3 5 4 3", "kinds: RGB-color space space space\n")); }),
      HasSubstr("axis 0 ('rgb-color') holds 3 values a voxel"));
  EXPECT_THAT(
      errorOf([] {
        parse(fourDimensional("3 5 4 3", "space directions: none (1,0,0) (0,1,0) (0,0,1)\n"));
      }),
      HasSubstr("axis 0 (not of space) holds 3 values a voxel"));
  EXPECT_THAT(errorOf([] { parse(fourDimensional("3 5 4 3", "spacings: nan 1 1 1\n")); }),
              HasSubstr("holds 3 values a voxel"));
}

TEST(NrrdHeaderTest, fewerAxesMakeAThinVolume) {
  const VolumeLayout layout =
      parse(
          "NRRD0001\ntype: float\ndimension: 2\nsizes: 7 6\nspace directions: (0,0,2) (0,3,0)\n"
          "encoding: ascii\n\n")
          .layout;
  EXPECT_TRUE(layout.dims == (Vec3i{7, 6, 1}));
  EXPECT_NEAR(std::abs(layout.axes[2].x), 1, 1e-12);
}

TEST(NrrdHeaderTest, minAndMaxAreTheStoredRange) {
  std::string text = kPlainNrrd;
  EXPECT_EQ(parse(text + "min: -3\nmax: 40.5\n\n").layout.stored_range, (ValueRange{-3, 40.5}));
  EXPECT_FALSE(parse(text + "min: nan\nmax: 40.5\n\n").layout.stored_range);
  EXPECT_FALSE(parse(text + "max: 40.5\n\n").layout.stored_range);
}

TEST(NrrdHeaderTest, namesDataFiles) {
  EXPECT_EQ(parse(headerWith("data file", "./my tooth.raw")).files.name(0), "./my tooth.raw");
  EXPECT_EQ(parse(headerWith("datafile", "x%d 1 3 1")).files.name(2), "x3");
  EXPECT_EQ(parse(headerWith("data file", "LIST 3\none.raw\nthree.raw\ntwo.raw")).files.count(), 3);
  EXPECT_EQ(parse(headerWith("data file", "x%02d 0 11 1 1")).files.name(11), "x11");
  EXPECT_EQ(parse(headerWith("data file", "LIST 3\nall.raw")).files.name(0), "all.raw");
}

TEST(NrrdHeaderTest, rejectsEachFieldThatIsWrong) {
  struct Case {
    const char *field, *value, *expected;
  };
  const Case cases[] = {
      {"type", "", "no field 'type'"},
      {"type", "block", "voxel type 'block' is not read"},
      {"type", "long long", "is not read"},
      {"type", "unsigned", "is not read"},
      {"dimension", "", "no field 'dimension'"},
      {"dimension", "0", "dimension: '0' is no whole number from 1 to 16"},
      {"dimension", "17", "dimension"},
      {"dimension", "-3", "dimension"},
      {"dimension", "3.0", "dimension"},
      {"dimension", "99999999999999999999", "dimension"},
      {"dimension", "2", "sizes: 3 values, 2 axes"},
      {"sizes", "", "no field 'sizes'"},
      {"sizes", "5 4", "sizes: 2 values, 3 axes"},
      {"sizes", "5 4 0", "sizes: '0' is no whole number from 1"},
      {"sizes", "5 4 -3", "sizes: '-3'"},
      {"sizes", "5 4 x", "sizes: 'x'"},
      {"sizes", "5 4 1e3", "sizes: '1e3'"},
      {"sizes", "9223372036854775807 2 2", "do not fit 2^62 bytes"},
      {"sizes", "9223372036854775808 1 1", "sizes: '9223372036854775808'"},
      {"sizes", "3037000500 3037000500 1", "do not fit 2^62 bytes"},
      {"encoding", "", "no field 'encoding'"},
      {"encoding", "bzip2", "encoding 'bzip2' is not read; convert"},
      {"encoding", "hex", "encoding 'hex' is not read"},
      {"endian", "", "no field 'endian', which i16 voxels need"},
      {"endian", "middle", "neither 'little' nor 'big'"},
      {"line skip", "-1", "line skip: '-1'"},
      {"line skip", "many", "line skip"},
      {"byte skip", "-2", "byte skip: '-2'"},
      {"byte skip", "9223372036854775807", "byte skip"},
      {"spacings", "1 1", "spacings: 2 values, 3 axes"},
      {"spacings", "1 1 0", "the step (0, 0, 0), is not from 1e-30"},
      {"spacings", "1 1 inf", "the step (0, 0, inf)"},
      {"spacings", "1 1 1e300", "the spacing of axis 2"},
      {"spacings", "1 1 1e-300", "the spacing of axis 2"},
      {"spacings", "1 1 x", "spacings: 'x' is no number"},
      {"axis mins", "1 1", "axis mins: 2 values, 3 axes"},
      {"axis maxs", "1 1 x", "axis maxs: 'x' is no number"},
      {"kinds", "domain domain", "kinds: 2 values, 3 axes"},
      {"kinds", "vector domain domain", "axis 0 ('vector') holds 5 values"},
      {"space directions", "(1,0,0) (0,1,0)", "fewer vectors than the 3 axes"},
      {"space directions", "(1,0,0) (0,1,0) (0,0,1) (0,0,1)", "more vectors"},
      {"space directions", "(1,0,0) (0,1,0) (0,0,1", "is no vector"},
      {"space directions", "(1,0,0) (0,1,0) x", "is no vector"},
      {"space directions", "(1,0,0) (0,1,0) (0,0,nan)", "the step (0, 0, nan)"},
      {"space directions", "(1,0,0) (0,1,0) (0,0,1e200)", "the spacing of axis 2"},
      {"space directions", "(1,0,0) (0,1,0) (1,1,0)", "lie in one plane"},
      {"space directions", "(1,0,0) (0,1,0) ()", "has 0 numbers"},
      {"space directions", "(1,0,0) (0,1,0) (1,2,3,4,5)", "has 5 numbers"},
      {"space origin", "(0,0,nan)", "origin (0, 0, nan) is not finite"},
      {"space origin", "(0,0,1e31)", "beyond 1e+30"},
      {"space origin", "0 0 0", "is no vector"},
      {"data file", "LIST", "no names after it"},
      {"data file", "LIST 9\na", "data file: '9'"},
      {"data file", "LIST\na\nb", "2 data files of 2 dimensions named, 3 expected"},
      {"data file", "x%d 1 1000000000000 1", "1000000000000 data files of 2 dimensions named"},
      {"data file", "x%d 1 3 0", "in steps of 0"},
      {"data file", "x%s 1 3 1", "exactly one number"},
      {"data file", "x%d 1 2 1 3", "do not share out the 3 elements"},
      {"data file", "bell\a", "is no name of a data file"},
  };
  for (const Case& c : cases) {
    const std::string line = errorOf([&] { parse(headerWith(c.field, c.value)); });
    EXPECT_THAT(line, StartsWith("v.nrrd: ")) << c.field << ": " << c.value;
    EXPECT_THAT(line, HasSubstr(c.expected)) << c.field << ": " << c.value;
  }
  EXPECT_THAT(errorOf([] { parse(std::string(kPlainNrrd) + "min: 5\nmax: 4\n\n"); }),
              HasSubstr("above its greatest"));
  EXPECT_THAT(errorOf([] { parse(std::string(kPlainNrrd) + "type: short\n\n"); }),
              HasSubstr("the field 'type' twice"));
  EXPECT_THAT(errorOf([] { parse(std::string(kPlainNrrd) + "nonsense\n\n"); }),
              HasSubstr("'nonsense' is no 'field: value'"));
  EXPECT_THAT(errorOf([] { parse(headerWith("encoding", "gzip\nbyte skip: -1")); }),
              HasSubstr("byte skip -1 needs encoding raw"));
}

TEST(NrrdHeaderTest, rejectsWhatIsNoNrrd) {
  for (const char* text : {"", "\n", "NRRD", "NRRD0009\n", "NRRD00045\n", "P5\n", "NRRD0000\n"})
    EXPECT_THAT(errorOf([&] { parse(text); }), HasSubstr("no NRRD file")) << text;
}

TEST(NrrdHeaderTest, everyTruncationIsAnError) {
  const std::string whole = std::string(kPlainNrrd) + "\n";
  for (size_t length = 0; length < whole.size(); ++length)
    errorOf([&] { parse(whole.substr(0, length)); });
}

}  // namespace
}  // namespace sluice::nrrd_header_test
