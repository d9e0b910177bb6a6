#include "io/headers/meta_image/meta_image.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "io/headers/meta_image/meta_image_header.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::meta_image_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr Vec3i kDims{5, 4, 3};

// A header, its keys in the order of the library that the format comes from; ElementDataFile last.
std::string headerWith(const std::string& key = "", const std::string& value = "") {
  constexpr std::array<std::pair<const char*, const char*>, 6> kPlain = {
      {{"ObjectType", "Image"},
       {"NDims", "3"},
       {"DimSize", "5 4 3"},
       {"ElementType", "MET_SHORT"},
       {"ElementByteOrderMSB", "False"},
       {"ElementDataFile", "LOCAL"}}};
  std::string text;
  bool there = key.empty();
  for (const auto& [name, plain] : kPlain) {
    if (std::string(name) == "ElementDataFile" && !there && key != name)
      text.append(key).append(" = ").append(value).append("\n");
    const bool changed = key == name;
    there = there || changed;
    if (changed && value.empty()) continue;
    text += std::string(name) + " = " + (changed ? value : plain) + "\n";
  }
  return text;
}

VolumeDescription parse(const std::string& text) {
  return parseMetaImageHeader(text, "v.mha");
}

void expectNear(Vec3d actual, Vec3d expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], 1e-12) << axis;
}

TEST(MetaImageHeaderTest, readsAPlainHeader) {
  const VolumeDescription d = parse(headerWith() + "voxels = none\n");
  EXPECT_TRUE(d.layout.dims == kDims);
  EXPECT_EQ(d.layout.type, VoxelType::kI16);
  EXPECT_EQ(d.byte_order, std::endian::little);
  EXPECT_EQ(d.encoding, Encoding::kRaw);
  EXPECT_TRUE(d.files.attached());
  EXPECT_EQ(d.data_offset, headerWith().size());
}

TEST(MetaImageHeaderTest, theWorldIsItksWhereTheHeaderKnowsOfOne) {
  const std::string matrix = "TransformMatrix = 1 0 0 0 1 0 0 0 1\n";
  const auto frameOf = [](const std::string& more) {
    return parse(more + headerWith()).layout.frame;
  };
  EXPECT_EQ(frameOf(""), WorldFrame::kNone);
  EXPECT_EQ(frameOf(matrix), WorldFrame::kLps);
  EXPECT_EQ(frameOf(matrix + "AnatomicalOrientation = RAI\n"), WorldFrame::kLps);
  EXPECT_EQ(frameOf("AnatomicalOrientation = lps\n"), WorldFrame::kLps);
  EXPECT_EQ(frameOf(matrix + "AnatomicalOrientation = ???\n"), WorldFrame::kNone);
  EXPECT_EQ(parse("DistanceUnits = um\n" + headerWith()).layout.unit, "micrometer");
}

TEST(MetaImageHeaderTest, readsEveryKeyThatMatters) {
  const VolumeDescription d = parse(
      "ObjectType = Image\r\nComment = a = b\r\nNDims = 4\r\nBinaryData = True\r\n"
      "BinaryDataByteOrderMSB = True\r\nCompressedData = True\r\nCompressedDataSize = 77\r\n"
      "TransformMatrix = 0 1 0 0 0 0 -1 0 1 0 0 0 0 0 0 1\r\nOffset = 1 -2 3e1 99\r\n"
      "AnatomicalOrientation = RAI\r\nElementSpacing = 2 3 4 0.1\r\nDimSize = 5 4 3 2\r\n"
      "ElementMin = -5\r\nElementMax = 7\r\nElementToIntensityFunctionSlope = 0.5\r\n"
      "ElementToIntensityFunctionOffset = -1000\r\nElementNumberOfChannels = 1\r\n"
      "ElementType = MET_FLOAT\r\nElementDataFile = v 1.zraw\r\n");
  const VolumeLayout& layout = d.layout;
  EXPECT_EQ(d.byte_order, std::endian::big);
  EXPECT_EQ(d.encoding, Encoding::kDeflate);
  EXPECT_EQ(layout.time_steps, 2);
  expectNear(layout.spacing, {2, 3, 4});
  expectNear(layout.axes[0], {0, 1, 0});
  expectNear(layout.axes[1], {0, 0, -1});
  expectNear(layout.axes[2], {1, 0, 0});
  expectNear(layout.origin, {1, -2, 30});
  EXPECT_EQ(layout.stored_range, (ValueRange{-5, 7}));
  EXPECT_EQ(layout.value_scale, 0.5);
  EXPECT_EQ(layout.value_offset, -1000);
  EXPECT_EQ(d.files.name(0), "v 1.zraw");
}

TEST(MetaImageHeaderTest, namesKeysThatAreMisspeltAndNoOthers) {
  EXPECT_EQ(parse(headerWith("HeaderSiz", "7")).layout.notes,
            std::vector<std::string>{"v.mha: its header has a field without a meaning, which is "
                                     "passed over: 'HeaderSiz'"});
  EXPECT_EQ(parse(headerWith("elementspacing", "1 1 2")).layout.notes.size(), 1U);
  for (const char* known : {"0008|0005", "ITK_original_direction", "Study", "HeaderSizePerSlice"})
    EXPECT_EQ(parse(headerWith(known, "7")).layout.notes.size(), 0U) << known;
}

TEST(MetaImageHeaderTest, aNegativeSpacingIsWarnedOf) {
  const VolumeLayout layout = parse(headerWith("ElementSpacing", "1 -2 3")).layout;
  expectNear(layout.axes[1], {0, -1, 0});
  ASSERT_EQ(layout.notes.size(), 1U);
  EXPECT_THAT(layout.notes[0], testing::StartsWith("v.mha: its spacing is 1 x -2 x 3: an axis of "
                                                   "negative spacing runs the other way"));
}

TEST(MetaImageHeaderTest, olderKeysStandIn) {
  const VolumeDescription d = parse(
      "NDims = 2\nDimSize = 5 4\nElementSize = 2 3\nPosition = 7 8\nOrientation = 0 1 1 0\n"
      "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n");
  EXPECT_TRUE(d.layout.dims == (Vec3i{5, 4, 1}));
  expectNear(d.layout.spacing, {2, 3, 1});
  expectNear(d.layout.axes[0], {0, 1, 0});
  expectNear(d.layout.origin, {7, 8, 0});
}

TEST(MetaImageHeaderTest, namesDataFiles) {
  const auto files = [](const std::string& value) {
    return parse(headerWith("ElementDataFile", value)).files;
  };
  EXPECT_EQ(files("LIST\na.raw\nb.raw\n\nc.raw\n").name(2), "c.raw");
  EXPECT_EQ(files("LIST 3D\nall.raw\n").count(), 1);
  EXPECT_EQ(files("LIST 1\n1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n").count(), 12);
  EXPECT_EQ(files("slice%03d.raw 10 30 10").name(1), "slice020.raw");
}

TEST(MetaImageHeaderTest, rejectsEachKeyThatIsWrong) {
  struct Case {
    const char *key, *value, *expected;
  };
  const Case cases[] = {
      {"ObjectType", "Scene", "'Scene' is no Image"},
      {"NDims", "", "has no NDims"},
      {"NDims", "1", "NDims = '1' is no whole number from 2 to 4"},
      {"NDims", "5", "NDims"},
      {"NDims", "-3", "NDims"},
      {"NDims", "x", "NDims"},
      {"NDims", "2", "DimSize has 3 numbers, NDims is 2"},
      {"DimSize", "", "has no DimSize"},
      {"DimSize", "5 4", "DimSize has 2 numbers"},
      {"DimSize", "5 4 0", "DimSize = '0'"},
      {"DimSize", "5 4 -3", "DimSize = '-3'"},
      {"DimSize", "5 4 3.5", "DimSize = '3.5'"},
      {"DimSize", "3037000500 3037000500 1", "do not fit 2^62 bytes"},
      {"DimSize", "99999999999999999999 1 1", "DimSize = '99999999999999999999'"},
      {"ElementType", "", "has no ElementType"},
      {"ElementType", "MET_LONG_LONG", "'MET_LONG_LONG' is not read"},
      {"ElementType", "MET_UCHAR_ARRAY", "is not read"},
      {"ElementNumberOfChannels", "3", "3 channels; only volumes of one value"},
      {"ElementNumberOfChannels", "0", "ElementNumberOfChannels"},
      {"ElementByteOrderMSB", "maybe", "neither True nor False"},
      {"CompressedData", "2", "neither True nor False"},
      {"CompressedDataSize", "-1", "CompressedDataSize"},
      {"BinaryData", "x", "neither True nor False"},
      {"ElementSpacing", "1 1", "ElementSpacing has 2 numbers, 3 expected"},
      {"ElementSpacing", "1 1 x", "'x' is no number"},
      {"ElementSpacing", "1 1 0", "spacing of axis 2"},
      {"ElementSpacing", "1 nan 1", "spacing of axis 1"},
      {"ElementSpacing", "inf 1 1", "spacing of axis 0"},
      {"ElementSpacing", "1 1 1e300", "spacing of axis 2"},
      {"Offset", "1 2", "Offset has 2 numbers"},
      {"Offset", "1 2 inf", "origin (1, 2, inf)"},
      {"Offset", "nan 2 3", "origin (nan, 2, 3)"},
      {"TransformMatrix", "1 0 0 0 1 0 0 0", "has 8 numbers, 9 expected"},
      {"TransformMatrix", "1 0 0 0 1 0 1 1 0", "lie in one plane"},
      {"TransformMatrix", "1 0 0 0 1 0 0 0 0", "spacing of axis 2"},
      {"TransformMatrix", "1 0 0 0 nan 0 0 0 1", "spacing of axis 1"},
      {"ElementToIntensityFunctionSlope", "0", "* 0 + 0: expected a factor of"},
      {"ElementToIntensityFunctionSlope", "nan", "* nan + 0: expected a factor of"},
      {"ElementToIntensityFunctionOffset", "inf", "* 1 + inf: expected"},
      {"ElementDataFile", "", "has no ElementDataFile"},
      {"ElementDataFile", "LIST", "no names after it"},
      {"ElementDataFile", "LIST 9D\na", "ElementDataFile = '9'"},
      {"ElementDataFile", "LIST\na\nb", "2 data files of 2 dimensions named, 3 expected"},
      {"ElementDataFile", "f%d 1 900000000000 1", "900000000000 data files"},
      {"ElementDataFile", "f%d 1 3 0", "in steps of 0"},
      {"ElementDataFile", "f%d%d 1 3 1", "exactly one number"},
  };
  for (const Case& c : cases) {
    const std::string line = errorOf([&] { parse(headerWith(c.key, c.value)); });
    EXPECT_THAT(line, StartsWith("v.mha: ")) << c.key << " = " << c.value;
    EXPECT_THAT(line, HasSubstr(c.expected)) << c.key << " = " << c.value;
  }
  EXPECT_THAT(errorOf([] { parse("NDims = 3\nNDims = 3\n"); }), HasSubstr("'NDims' twice"));
  EXPECT_THAT(errorOf([] {
                parse(
                    "\x7f"
                    "ELF\n");
              }),
              HasSubstr("is no 'Key = Value'"));
  const auto detached = [](const std::string& more) {
    return "NDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\n" + more +
           "ElementDataFile = a.raw\n";
  };
  EXPECT_THAT(errorOf([&] { parse(detached("HeaderSize = -2\n")); }),
              HasSubstr("HeaderSize = '-2'"));
  EXPECT_THAT(errorOf([&] { parse(detached("HeaderSize = 9223372036854775807\n")); }),
              HasSubstr("HeaderSize"));
  EXPECT_THAT(errorOf([&] { parse(detached("HeaderSize = -1\nCompressedData = True\n")); }),
              HasSubstr("HeaderSize -1"));
  EXPECT_THAT(errorOf([&] { parse(detached("BinaryData = False\nCompressedData = True\n")); }),
              HasSubstr("needs BinaryData"));
}

TEST(MetaImageHeaderTest, everyTruncationIsAnError) {
  const std::string whole = headerWith();
  // All of "ElementDataFile = L" and longer names a file, which then is missing.
  const size_t named = whole.rfind("LOCAL") + 1;
  for (size_t length = 0; length < named; ++length)
    errorOf([&] { parse(whole.substr(0, length)); });
}

TEST(MetaImageHeaderTest, isCompleteWithTheLineOfTheDataFile) {
  const std::string whole = headerWith();
  EXPECT_TRUE(metaImageHeaderComplete(whole));
  EXPECT_FALSE(metaImageHeaderComplete(whole.substr(0, whole.size() - 1)));
  EXPECT_FALSE(metaImageHeaderComplete(headerWith("ElementDataFile", "LIST\na\nb\nc\n")));
}

// ---- Files -----------------------------------------------------------------------------------

TEST(MetaImageTest, readsLocalListedAndNumberedData) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kDims);
  const VoxelType type = VoxelType::kI16;
  expectKnownVolume(*openMetaImage(folder.write("a.mha", headerWith() + voxels)), type, kDims);
  for (size_t z = 0; z < 3; ++z)
    folder.write(fmt::format("s{}", z), "head" + voxels.substr(z * 40, 40));
  const std::string skip = headerWith("HeaderSize", "4");
  const std::string listed = skip.substr(0, skip.rfind("LOCAL"));
  expectKnownVolume(*openMetaImage(folder.write("b.mhd", listed + "LIST\ns0\ns1\ns2\n")), type,
                    kDims);
  expectKnownVolume(*openMetaImage(folder.write("c.mhd", listed + "s%d 0 2 1")), type, kDims);
}

TEST(MetaImageTest, headerSizeMinusOneTakesTheLastBytes) {
  const TempFolder folder;
  folder.write("v.raw", "a header of unknown length" + knownVoxels(VoxelType::kI16, kDims));
  std::string text = headerWith("HeaderSize", "-1");
  text.replace(text.rfind("LOCAL"), 5, "v.raw");
  expectKnownVolume(*openMetaImage(folder.write("v.mhd", text)), VoxelType::kI16, kDims);
  folder.write("v.raw", "short");
  EXPECT_THAT(
      errorOf([&] { openMetaImage(folder / "v.mhd"); }),
      HasSubstr("v.raw: 5 x 4 x 3 x 2 bytes (i16) + 0 skipped = 120 bytes expected, 5 found"));
}

TEST(MetaImageTest, readsVoxelsWrittenAsText) {
  const TempFolder folder;
  std::string text = headerWith("BinaryData", "False");
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 5; ++x)
        text += std::to_string(static_cast<int>(knownVoxel(VoxelType::kI16, {x, y, z}))) + " ";
  expectKnownVolume(*openMetaImage(folder.write("t.mha", text)), VoxelType::kI16, kDims);
}

TEST(MetaImageTest, aDifferentFileIsToldApartAtOnce) {
  const TempFolder folder;
  const auto path = folder.write("a.mha", "P5\n");
  std::filesystem::resize_file(path, int64_t{1} << 33);
  EXPECT_THAT(errorOf([&] { openMetaImage(path); }), HasSubstr("a.mha: "));
}

TEST(MetaImagePeerTest, readsWhatVtkWrites) {
  SLUICE_NEEDS_MODULE("vtk");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import vtk
from vtk.util.numpy_support import numpy_to_vtk
for kind in ['u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8']:
    image = vtk.vtkImageData()
    image.SetDimensions(5, 4, 3)
    image.SetSpacing(1, 2, 0.5)
    image.SetOrigin(-1, 7, 3)
    array = numpy_to_vtk(known(kind, 5, 4, 3).ravel(order='F'), deep=True)
    image.GetPointData().SetScalars(array)
    for name, compressed in [('.mha', True), ('.mhd', True), ('plain.mha', False), ('plain.mhd', False)]:
        writer = vtk.vtkMetaImageWriter()
        writer.SetInputData(image)
        writer.SetFileName(folder + kind + name)
        if name.endswith('mhd'):
            writer.SetRAWFileName(folder + kind + name[:-4] + ('.zraw' if compressed else '.raw'))
        writer.SetCompression(compressed)
        writer.Write()
)")) << readFile(folder / "script.log");
  constexpr std::array<const char*, 8> kKinds = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};
  for (size_t i = 0; i < kKinds.size(); ++i)
    for (const char* name : {".mha", ".mhd", "plain.mha", "plain.mhd"}) {
      const std::string file = std::string(kKinds[i]) + name;
      SCOPED_TRACE(file);
      const auto source = openMetaImage(folder / file);
      expectKnownVolume(*source, static_cast<VoxelType>(i), kDims);
      expectNear(source->layout().spacing, {1, 2, 0.5});
      expectNear(source->layout().origin, {-1, 7, 3});
    }
}

}  // namespace
}  // namespace sluice::meta_image_test
