#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "io/open_volume.h"
#include "io/vtk/vtk_image.h"
#include "io/vtk/vtk_source.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/volume_channels.h"
#include "tests/io/python_volumes.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A file of make_vtk.py.
struct VtkCase {
  static constexpr const char* kScript = "make_vtk.py";
  static constexpr const char* kModules = "numpy, vtkmodules";
  std::string name, type, array;
  Vec3i dims;

  friend std::istream& operator>>(std::istream& line, VtkCase& c) {
    return line >> c.name >> c.type >> c.dims.x >> c.dims.y >> c.dims.z >> c.array;
  }
  ChannelWish wish() const {
    ChannelWish wish;
    if (array != "-") wish.name = array;
    return wish;
  }
};

class Vtk : public PythonVolumesTest<VtkCase> {
 protected:
  static std::unique_ptr<VolumeSource> open(const std::string& name,
                                            const ChannelWish& channel = {}) {
    return openVtk(pathOf(name), channel, {});
  }
  // The error from reading a changed copy of a file.
  static std::string errorOfChanged(const std::string& name,
                                    const std::function<void(std::string&)>& change) {
    const TempFolder folder;
    std::string text = readFile(pathOf(name));
    change(text);
    std::ofstream(folder / name, std::ios::binary) << text;
    return errorOf([&] { readAll(*openVolume((folder / name).string())); });
  }
};

void replace(std::string& text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

TEST_F(Vtk, filesAreReadAsTheyWereWritten) {
  ASSERT_GT(cases_.size(), 110U);
  for (const VtkCase& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = open(c.name, c.wish());
    EXPECT_EQ(source->layout().dims, c.dims);
    EXPECT_EQ(name(source->layout().type), c.type);
    EXPECT_EQ(source->layout().spacing, (Vec3d{0.5, 0.25, 2}));
    const std::string whole = voxelsOf(c.name);
    EXPECT_TRUE(asText(readAll(*source)) == whole);
    expectBoxesAreParts(*source, whole);
  }
}

TEST_F(Vtk, voxelsLieWhereExtentAndDirectionPutThem) {
  EXPECT_EQ(open("raw_uint8.vti")->layout().origin, (Vec3d{1, 2, 3}));
  EXPECT_EQ(open("start.vti")->layout().origin, (Vec3d{1 - 1.5, 2 + 1, 3 + 20}));
  EXPECT_EQ(open("cells.vti")->layout().origin, (Vec3d{1 + 1.25, 2 + 0.125, 3 + 1}));
  const VolumeLayout turned = open("turned.vti")->layout();
  EXPECT_THAT(turned.axes, ElementsAre(Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 0, 1}));
}

TEST_F(Vtk, arraysAreChannelsByName) {
  for (const std::string name : {"several_appended.vti", "several_False.vtk"}) {
    const auto source = openVolume(pathOf(name).string());
    EXPECT_EQ(source->layout().channels, 3);
    EXPECT_THAT(channelNames(*source), ElementsAre("first", "second one", "third"));
    EXPECT_NE(source->identity(), openVolume(pathOf(name).string(), {.channel = 2})->identity());
    EXPECT_THAT(errorOf([&] { openVolume(pathOf(name).string(), {.channel = 3}); }),
                HasSubstr("3 channels"));
  }
}

// Appended raw numbers are read in place: a voxel costs little more than the header.
TEST_F(Vtk, appendedNumbersAreReadInPlace) {
  const auto source = open("raw_float64.vti");
  const uint64_t header = source->storedBytesRead();
  readBox(*source, {{0, 0, 0}, {1, 1, 1}}, 0);
  EXPECT_EQ(source->storedBytesRead() - header, 8U);
}

TEST_F(Vtk, compressedBlocksAreReadOneByOne) {
  const auto source = open("zlib_float64.vti");
  const uint64_t header = source->storedBytesRead();
  EXPECT_EQ(readUnits(*source).voxels, (Vec3i{13, 9, 1}));
  EXPECT_EQ(source->heldBytesAThread(), 3U * 1024);
  readBox(*source, {{0, 0, 0}, {1, 1, 1}}, 0);
  const uint64_t one = source->storedBytesRead() - header;
  EXPECT_LT(one, 1200U);
  readBox(*source, {{1, 0, 0}, {2, 1, 1}}, 0);
  EXPECT_EQ(source->storedBytesRead() - header, one);
}

TEST_F(Vtk, wrongFilesAreNamed) {
  const auto with = [](const std::string& from, const std::string& to) {
    return [from, to](std::string& text) { replace(text, from, to); };
  };
  // A number more in the first array.
  const auto inFront = [](const std::string& number) {
    return [number](std::string& text) {
      text.insert(text.find('>', text.find("<DataArray")) + 1, number);
    };
  };
  struct Damage {
    std::string file;
    std::function<void(std::string&)> change;
    std::string said;
  };
  const Damage damages[] = {
      {"raw_uint8.vti", with("ImageData\"", "PolyData\""), "of ImageData, found one of 'PolyData'"},
      {"raw_uint8.vti", with("LittleEndian", "Middle"), "byte_order"},
      {"raw_uint8.vti", with("UInt32", "UInt16"), "header_type"},
      {"raw_uint8.vti", with("0 12 0 10 0 8", "0 12 0 10"), "6 numbers as WholeExtent"},
      {"raw_uint8.vti", with("0 12 0 10 0 8", "0 12 0 -1 0 8"), "one Piece of the whole extent"},
      {"raw_uint8.vti", with("Piece Extent=\"0 12", "Piece Extent=\"0 11"), "one Piece"},
      {"raw_uint8.vti", with("type=\"UInt8\"", "type=\"Int64\""),
       "found 'a' (1 of 'Int64' a point)"},
      {"raw_uint8.vti", with("type=\"UInt8\"", "type=\"UInt16\""),
       "expected 2574 bytes, as the extent makes, found 1287"},
      {"raw_uint8.vti", with("Spacing=\"0.5 0.25 2\"", "Spacing=\"0.5 0 2\""), "spacing of axis 1"},
      {"raw_uint8.vti", with("   _", "   "), "'_' in front of the appended data"},
      {"raw_uint8.vti", with("encoding=\"raw\"", "encoding=\"hex\""), "encoding raw or base64"},
      {"raw_uint8.vti", with("offset=\"0\"", "offset=\"-1\""), "offset of 0 or more"},
      {"raw_uint8.vti", with("offset=\"0\"", "offset=\"99999999\""), "cut short"},
      {"raw_uint8.vti", [](std::string& text) { text.resize(1500); }, "cut short"},
      {"raw_uint8.vti", [](std::string& text) { text.resize(300); }, "expected XML, found"},
      {"raw_uint8.vti", with("<VTKFile", "<!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile"),
       "without a document type declaration"},
      {"raw_uint8.vti", with("<PointData", "<PointData A=\"" + std::string(2 << 20, 'a') + "\""),
       "expected tags of at most"},
      {"base64_uint8.vti", with("AAAA", "AA*A"), "base64"},
      {"base64_uint8.vti", [](std::string& text) { text.resize(text.size() / 2); },
       "expected XML, found"},
      {"ascii_int16.vti", inFront(" x "), "is no i16 value"},
      {"ascii_int16.vti", inFront(" 0 "), "the stream goes on after them"},
      {"binaryFalseZLibFalseFalse512.vti", with("BgAAAAACAAAOAAAA", "BgAAAAACAAAPAAAA"),
       "expected blocks of 2574 bytes together"},
      {"binaryFalseZLibFalseFalse512.vti", with("eF5t", "eF5u"), "block 0"},
      {"legacy_int16_False.vtk", with("BINARY", "BINAR"), "ASCII or BINARY in line 3"},
      {"legacy_int16_False.vtk", with("STRUCTURED_POINTS", "POLYDATA"), "found 'DATASET'"},
      {"legacy_int16_False.vtk", with("13 11 9", "13 11 8"), "as DIMENSIONS make, found 1287"},
      {"legacy_int16_False.vtk", with("13 11 9", "13 11 0"), "one point or more"},
      {"legacy_int16_False.vtk", with("SCALARS", "SCALAR"), "expected DIMENSIONS, ORIGIN"},
      {"legacy_int16_False.vtk", [](std::string& text) { text.resize(1000); }, "cut short"},
      {"legacy_int16_True.vtk", [](std::string& text) { text.resize(1000); }, "cut short"}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.file + ": " + damage.said);
    EXPECT_THAT(errorOfChanged(damage.file, damage.change),
                AllOf(HasSubstr(damage.file + ": "), HasSubstr(damage.said)));
  }
}

TEST(VtkImage, aNegativeSpacingIsWarnedOf) {
  const TempFolder folder;
  const auto path = folder.write(
      "v.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 2\n"
      "SPACING 1 1 -2\nORIGIN 0 0 0\nPOINT_DATA 4\nSCALARS a short 1\nLOOKUP_TABLE default\n"
      "1 2 3 4\n");
  EXPECT_THAT(openVtk(path, {}, {})->layout().notes,
              ElementsAre(HasSubstr("v.vtk: its spacing is 1 x 1 x -2")));
}

TEST(VtkImage, coloursAsTextAreRefusedWithWhatToDo) {
  const TempFolder folder;
  const auto path = folder.write(
      "c.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\n"
      "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 4\nCOLOR_SCALARS a 1\n0 0.2 0.4 1\n");
  EXPECT_THAT(errorOf([&] { openVtk(path, {}, {}); }),
              HasSubstr("found 'a' (COLOR_SCALARS as text, 1 a point; write the file as BINARY, or "
                        "the numbers as SCALARS)"));
}

TEST(VtkImage, legacyArraysBehindOthersAreFound) {
  const std::string text =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\n"
      "ASPECT_RATIO 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 2\nSCALARS a int 2\nLOOKUP_TABLE t\n1 2\n3 4\n"
      "LOOKUP_TABLE t 1\n0 0 0 1\nVECTORS v float\n1 2 3 4 5 6\nMETADATA\nINFORMATION 0\n\n"
      "FIELD f 2\nb%20c 1 2 short\n5 6\nd 1 1 double\n7\nCELL_DATA 1\nSCALARS e char\n"
      "LOOKUP_TABLE default\n8\n";
  const VtkImage image = parseLegacyVtk(
      [&](uint64_t offset, std::span<std::byte> out) {
        const std::string part = text.substr(std::min<size_t>(offset, text.size()), out.size());
        std::memcpy(out.data(), part.data(), part.size());
        return part.size();
      },
      "v");
  EXPECT_EQ(image.spacing, (Vec3d{1, 2, 3}));
  std::vector<std::string> found;
  for (const VtkArray& array : image.arrays)
    found.push_back(array.name + std::to_string(array.components) +
                    text.substr(array.offset, array.end - array.offset));
  EXPECT_THAT(found, ElementsAre("a21 2\n3 4", "v31 2 3 4 5 6", "b c15 6", "e18"));
}

}  // namespace
}  // namespace sluice
