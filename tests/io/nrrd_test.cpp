#include "io/nrrd.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "io/nrrd_header.h"
#include "tests/io/volume_files.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr Vec3i kDims{5, 4, 3};
constexpr const char* kPlain =
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\n";

VolumeDescription parse(const std::string& text) {
  return parseNrrdHeader(text, "v.nrrd");
}

// kPlain with a line replaced (told by its field), added, or (empty value) left out.
std::string headerWith(const std::string& field, const std::string& value) {
  std::string text = kPlain;
  const size_t begin = text.find(field + ": ");
  if (begin != std::string::npos) text.erase(begin, text.find('\n', begin) + 1 - begin);
  if (!value.empty()) text += field + ": " + value + "\n";
  return text + "\n";
}

void expectNear(Vec3d actual, Vec3d expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], 1e-12) << axis;
}

TEST(NrrdHeaderTest, readsAPlainHeader) {
  const VolumeDescription d = parse(std::string(kPlain) + "\nvoxels");
  EXPECT_TRUE(d.layout.dims == kDims);
  EXPECT_EQ(d.layout.type, VoxelType::kI16);
  EXPECT_EQ(d.byte_order, std::endian::little);
  EXPECT_EQ(d.encoding, Encoding::kRaw);
  EXPECT_EQ(d.data_offset, std::string(kPlain).size() + 1);
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
}

TEST(NrrdHeaderTest, spaceDirectionsAndOriginGiveTheWorld) {
  std::string text = kPlain;
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

std::string fourDimensional(const std::string& sizes, const std::string& more) {
  return "NRRD0004\ntype: uchar\ndimension: 4\nsizes: " + sizes + "\nencoding: raw\n" + more + "\n";
}

TEST(NrrdHeaderTest, theSlowestAxisOfFourIsTime) {
  for (const char* more :
       {"", "kinds: domain domain domain time\n", "spacings: 1 1 1 nan\n",
        "space directions: (1,0,0) (0,1,0) (0,0,1) none\n", "kinds: space space space list\n",
        "space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,1)\n"}) {
    const VolumeLayout layout = parse(fourDimensional("5 4 3 2", more)).layout;
    EXPECT_TRUE(layout.dims == kDims) << more;
    EXPECT_EQ(layout.time_steps, 2) << more;
  }
}

TEST(NrrdHeaderTest, anAxisOfOneElementThatIsNotOfSpaceIsDropped) {
  const VolumeLayout layout =
      parse(fourDimensional("1 5 4 3", "spacings: nan 2 3 4\nkinds: vector space space space\n"))
          .layout;
  EXPECT_TRUE(layout.dims == kDims);
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
  std::string text = kPlain;
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
  EXPECT_THAT(errorOf([] { parse(std::string(kPlain) + "min: 5\nmax: 4\n\n"); }),
              HasSubstr("above its greatest"));
  EXPECT_THAT(errorOf([] { parse(std::string(kPlain) + "type: short\n\n"); }),
              HasSubstr("the field 'type' twice"));
  EXPECT_THAT(errorOf([] { parse(std::string(kPlain) + "nonsense\n\n"); }),
              HasSubstr("'nonsense' is no 'field: value'"));
  EXPECT_THAT(errorOf([] { parse(headerWith("encoding", "gzip\nbyte skip: -1")); }),
              HasSubstr("byte skip -1 needs encoding raw"));
}

TEST(NrrdHeaderTest, rejectsWhatIsNoNrrd) {
  for (const char* text : {"", "\n", "NRRD", "NRRD0009\n", "NRRD00045\n", "P5\n", "NRRD0000\n"})
    EXPECT_THAT(errorOf([&] { parse(text); }), HasSubstr("no NRRD file")) << text;
}

TEST(NrrdHeaderTest, everyTruncationIsAnError) {
  const std::string whole = std::string(kPlain) + "\n";
  for (size_t length = 0; length < whole.size(); ++length)
    errorOf([&] { parse(whole.substr(0, length)); });
}

// ---- Files -----------------------------------------------------------------------------------

TEST(NrrdTest, readsAttachedDetachedAndMultiFileData) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kDims);
  const std::string big = swapped(voxels, VoxelType::kI16);
  expectKnownVolume(*openNrrd(folder.write("a.nrrd", std::string(kPlain) + "\n" + voxels)),
                    VoxelType::kI16, kDims);

  folder.write("b.raw", "line\nxy" + big);
  std::string text = headerWith("endian", "big");
  text.insert(text.size() - 1, "line skip: 1\nbyte skip: 2\ndata file: b.raw\n");
  expectKnownVolume(*openNrrd(folder.write("b.nhdr", text)), VoxelType::kI16, kDims);

  for (int z = 0; z < 3; ++z)
    folder.write("c" + std::to_string(z), "front" + voxels.substr(static_cast<size_t>(z) * 40, 40));
  const std::string detached = std::string(kPlain) + "byte skip: -1\ndata file: ";
  expectKnownVolume(*openNrrd(folder.write("c.nhdr", detached + "c%d 0 2 1\n")), VoxelType::kI16,
                    kDims);
  expectKnownVolume(*openNrrd(folder.write("d.nhdr", detached + "LIST\nc0\nc1\nc2\n")),
                    VoxelType::kI16, kDims);
}

TEST(NrrdTest, hundredsOfFilesDoNotUseUpTheDescriptors) {
  const TempFolder folder;
  const Vec3i dims{4, 3, 300};
  const std::string voxels = knownVoxels(VoxelType::kU8, dims);
  for (int z = 0; z < 300; ++z)
    folder.write("s" + std::to_string(z), voxels.substr(static_cast<size_t>(z) * 12, 12));
  const auto source =
      openNrrd(folder.write("s.nhdr",
                            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 300\nencoding: raw\n"
                            "data file: s%d 0 299 1\n"));
  expectKnownVolume(*source, VoxelType::kU8, dims);
  const auto open_files = std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  EXPECT_LT(open_files, 100);
  EXPECT_THAT(source->identity(), HasSubstr("|300 files "));
}

TEST(NrrdTest, identityFollowsEachDataFile) {
  const TempFolder folder;
  const std::string detached = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: raw\n";
  for (const char* name : {"f0", "f1"}) folder.write(name, "a");
  const auto header = folder.write("f.nhdr", detached + "data file: f%d 0 1 1\n");
  const std::string before = openNrrd(header)->identity();
  EXPECT_EQ(openNrrd(header)->identity(), before);
  folder.write("f1", "bc");
  EXPECT_NE(openNrrd(header)->identity(), before);
}

TEST(NrrdTest, countsTheBytesOfHeaderAndVoxelsOnce) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kDims);
  const auto attached = openNrrd(folder.write("a.nrrd", std::string(kPlain) + "\n" + voxels));
  const uint64_t header_bytes = attached->storedBytesRead();
  readAll(*attached);
  EXPECT_EQ(attached->storedBytesRead(), header_bytes + voxels.size());

  folder.write("b.raw", voxels);
  const std::string text = std::string(kPlain) + "data file: b.raw\n";
  const auto detached = openNrrd(folder.write("b.nhdr", text));
  EXPECT_EQ(detached->storedBytesRead(), text.size());
  readAll(*detached);
  EXPECT_EQ(detached->storedBytesRead(), text.size() + voxels.size());
}

TEST(NrrdTest, aFileTooSmallShowsTheArithmetic) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openNrrd(folder.write("a.nrrd", std::string(kPlain) + "\n123")); }),
              HasSubstr("a.nrrd: 5 x 4 x 3 x 2 bytes (i16) + 77 skipped = 197 bytes expected, 80 "
                        "found"));
  for (const char* name : {"c0", "c1", "c2"}) folder.write(name, std::string(40, 'a'));
  folder.write("c1", "short");
  EXPECT_THAT(errorOf([&] {
                openNrrd(folder.write("c.nhdr", std::string(kPlain) + "data file: c%d 0 2 1\n"));
              }),
              HasSubstr("c1: 5 x 4 x 3 x 2 bytes (i16) / 3 files + 0 skipped = 40 bytes expected, "
                        "5 found"));
}

TEST(NrrdTest, aMissingDataFileNamesBoth) {
  const TempFolder folder;
  const std::string line = errorOf(
      [&] { openNrrd(folder.write("a.nhdr", std::string(kPlain) + "data file: gone.raw\n")); });
  EXPECT_THAT(line, HasSubstr("a.nhdr: data file "));
  EXPECT_THAT(line, HasSubstr("gone.raw: cannot be opened"));
}

TEST(NrrdTest, tooFewLinesToSkipIsAnError) {
  const TempFolder folder;
  const std::string text = headerWith("line skip", "1000000000000");
  EXPECT_THAT(errorOf([&] { openNrrd(folder.write("a.nrrd", text + "a\nb\n")); }),
              HasSubstr("1000000000000 lines to skip, 2 found"));
}

TEST(NrrdTest, aHeaderWithoutEndIsNotReadForever) {
  const TempFolder folder;
  const auto path = folder.write("a.nrrd", std::string("NRRD0004\n") + std::string(100, '#'));
  std::filesystem::resize_file(path, int64_t{1} << 33);
  EXPECT_THAT(errorOf([&] { openNrrd(path); }), HasSubstr("no end of the header"));
}

// ---- Against teem ----------------------------------------------------------------------------

std::string unu() {
  return runs("unu --help") || runs("command -v unu") ? "unu" : "teem-unu";
}
constexpr const char* kFindUnu = "command -v unu || command -v teem-unu";

const char* unuType(VoxelType type) {
  constexpr std::array<const char*, 8> kNames = {"uchar", "signed char", "ushort", "short",
                                                 "uint",  "int",         "float",  "double"};
  return kNames[static_cast<size_t>(type)];
}

TEST(NrrdPeerTest, readsWhatUnuWrites) {
  SLUICE_NEEDS("teem's unu", kFindUnu);
  for (int i = 0; i < 8; ++i) {
    const auto type = static_cast<VoxelType>(i);
    const TempFolder folder;
    folder.write("v.raw", knownVoxels(type, kDims, 2));
    const std::string make = unu() + " make -i " + (folder / "v.raw").string() + " -t '" +
                             unuType(type) + "' -s 5 4 3 2 -sp 1 2 3 nan -e raw -en little | ";
    for (const char* how : {"-e raw -en little", "-e raw -en big", "-e gzip -en little",
                            "-e gz:9f -en big", "-e ascii"})
      for (const char* file : {"w.nrrd", "w.nhdr"}) {
        const auto path = folder / file;
        ASSERT_TRUE(runs(make + unu() + " save -f nrrd " + how + " -o " + path.string())) << how;
        const auto source = openNrrd(path);
        SCOPED_TRACE(std::string(how) + " " + std::string(name(type)) + " " + file);
        expectKnownVolume(*source, type, kDims, 2);
        EXPECT_TRUE(source->layout().spacing == (Vec3d{1, 2, 3}));
      }
  }
}

// The voxels that unu reads through a header of ours: little-endian.
std::string voxelsByUnu(const TempFolder& folder, const std::filesystem::path& header) {
  const std::string out = (folder / "unu.out").string();
  EXPECT_TRUE(runs(unu() + " save -f nrrd -e raw -en little -i " + header.string() + " | " + unu() +
                   " data - | cat > " + out));
  return readFile(out);
}

TEST(NrrdPeerTest, readsSkipsAsUnuDoes) {
  SLUICE_NEEDS("teem's unu", kFindUnu);
  SLUICE_NEEDS("gzip", "gzip --version");
  const TempFolder folder;
  const std::string front = "one\ntwo\nthree";
  folder.write("v", front + knownVoxels(VoxelType::kI16, kDims));
  ASSERT_TRUE(runs("gzip -k " + (folder / "v").string()));
  folder.write("v2.gz", "text\n" + readFile(folder / "v.gz"));
  const std::string detached =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\n";
  for (const char* more : {"encoding: raw\nline skip: 2\nbyte skip: 5\ndata file: v\n",
                           "encoding: raw\nbyte skip: -1\ndata file: v\n",
                           "encoding: gzip\nbyte skip: 13\ndata file: v.gz\n",
                           "encoding: gzip\nline skip: 1\nbyte skip: 13\ndata file: v2.gz\n"}) {
    const auto header = folder.write("h.nhdr", detached + more);
    SCOPED_TRACE(more);
    expectKnownVolume(*openNrrd(header), VoxelType::kI16, kDims);
    EXPECT_TRUE(voxelsByUnu(folder, header) == knownVoxels(VoxelType::kI16, kDims));
  }
}

TEST(NrrdPeerTest, readsSeveralFilesAsUnuDoes) {
  SLUICE_NEEDS("teem's unu", kFindUnu);
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kU8, kDims);
  for (size_t i = 0; i < 12; ++i) {
    char name[8];
    std::snprintf(name, sizeof(name), "r%02zu", i);
    folder.write(name, voxels.substr(5 * i, 5));
  }
  for (size_t i = 0; i < 3; ++i)
    folder.write("p" + std::to_string(2 * i), voxels.substr(20 * i, 20));
  const std::string detached = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n";
  for (const char* more :
       {"data file: r%02d 0 11 1 1\n", "data file: p%d 0 4 2\n", "data file: LIST\np0\np2\np4\n",
        "data file: p%d 0 4 2 2\n", "data file: LIST 3\np0\np2\np4\n"}) {
    const auto header = folder.write("h.nhdr", detached + more);
    SCOPED_TRACE(more);
    expectKnownVolume(*openNrrd(header), VoxelType::kU8, kDims);
    EXPECT_TRUE(voxelsByUnu(folder, header) == voxels);
  }
}

}  // namespace
}  // namespace sluice
