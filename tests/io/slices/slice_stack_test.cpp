#include "io/slices/slice_stack.h"

#include <gmock/gmock.h>

#include <thread>

#include "io/files/file_list.h"
#include "io/open_volume.h"
#include "io/pictures/png_file.h"
#include "io/slices/slice_picture.h"
#include "tests/io/python_volumes.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A stack of make_slices.py.
struct Case {
  static constexpr const char* kScript = "make_slices.py";
  static constexpr const char* kModules = "numpy, tifffile, vtkmodules.vtkIOImage";

  std::string name, type;
  Vec3i dims;

  friend std::istream& operator>>(std::istream& line, Case& c) {
    return line >> c.name >> c.type >> c.dims.x >> c.dims.y >> c.dims.z;
  }
};

class Slices : public PythonVolumesTest<Case> {
 protected:
  static std::filesystem::path firstOf(const std::string& name) {
    return listFolder(pathOf(name)).at(0);
  }
};

TEST_F(Slices, areReadAsOtherProgramsWroteThem) {
  ASSERT_GT(cases_.size(), 30U);
  for (const Case& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = openSliceFolder(pathOf(c.name));
    EXPECT_EQ(source->layout().dims, c.dims);
    EXPECT_EQ(name(source->layout().type), c.type);
    EXPECT_TRUE(asText(readAll(*source)) == voxelsOf(c.name));
  }
}

TEST_F(Slices, boxesInAnyOrderAreParts) {
  for (const Case& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = openSliceFolder(pathOf(c.name), {.held_bytes = 1, .max_open_pictures = 1});
    expectBoxesAreParts(*source, voxelsOf(c.name));
  }
}

// Below the band cache: rows are asked for in pieces, forward and back.
TEST_F(Slices, picturesGiveRowsInAnyOrder) {
  for (const Case& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto picture = openSlicePicture(firstOf(c.name));
    const std::string whole = voxelsOf(c.name);
    const size_t row = static_cast<size_t>(c.dims.x) * bytesPerVoxel(picture->format().type);
    for (const int64_t first : {0, 3, 4, 17, 2, 18}) {
      std::vector<std::byte> rows(2 * row);
      picture->readRows(0, 0, first, 2, rows);
      ASSERT_TRUE(asText(rows) == whole.substr(static_cast<size_t>(first) * row, 2 * row)) << first;
    }
  }
}

TEST_F(Slices, threadsReadAtOnce) {
  for (const char* name : {"png-vtk-u16", "tiff-one-strip-zlib", "tiff-pages"}) {
    const auto source =
        openSliceFolder(pathOf(name), {.held_bytes = 20'000, .max_open_pictures = 2});
    std::array<std::string, 4> read;
    std::vector<std::thread> threads;
    for (auto& mine : read) threads.emplace_back([&] { mine = asText(readAll(*source)); });
    for (auto& thread : threads) thread.join();
    for (const auto& mine : read) EXPECT_TRUE(mine == voxelsOf(name));
  }
}

TEST_F(Slices, readingBlockByBlockDecodesEachRowOnce) {
  for (const char* name : {"png-vtk-u16", "tiff-one-strip-zlib", "tiff-tiles-zlib", "tiff-u8"}) {
    SCOPED_TRACE(name);
    const auto source = openSliceFolder(pathOf(name));
    const Vec3i dims = source->layout().dims;
    const uint64_t opening = source->storedBytesRead();
    for (int64_t z = 0; z < dims.z; ++z)
      for (int64_t y = 0; y < dims.y; y += 8)
        for (int64_t x = 0; x < dims.x; x += 8)
          readBox(*source, intersect({{x, y, z}, {x + 9, y + 9, z + 1}}, boxOf(dims)));
    uint64_t stored = 0;
    for (const auto& file : listFolder(pathOf(name))) stored += std::filesystem::file_size(file);
    // Headers and libtiff's tables are added, for the opening and at the reading of rows.
    EXPECT_GT(source->storedBytesRead(), stored / 2);
    EXPECT_LT(source->storedBytesRead(), 2 * opening + stored + stored / 10);
  }
}

TEST_F(Slices, takeSpacingFromTheOptions) {
  const auto source = openSliceFolder(pathOf("tiff-u8"), {.spacing = Vec3d{1, 1, 2}});
  EXPECT_EQ(source->layout().spacing, (Vec3d{1, 1, 2}));
}

TEST_F(Slices, thatDifferAreNamed) {
  const auto same = listFolder(pathOf("tiff-u8"));
  EXPECT_THAT(
      errorOf([&] {
        openSlices({same[0], same[1], firstOf("png-gray-alpha")});
      }),
      AllOf(HasSubstr("png-gray-alpha"), HasSubstr("19 x 21 of u8, expected 53 x 70 of u8")));
  EXPECT_THAT(errorOf([&] {
                openSlices({same[0], firstOf("tiff-u16")});
              }),
              AllOf(HasSubstr("tiff-u16"), HasSubstr("of u16, expected")));
  EXPECT_THAT(errorOf([&] {
                openSlices({firstOf("tiff-pages"), same[0]});
              }),
              HasSubstr("11 pages among 2 files"));
}

TEST_F(Slices, rejectPagesThatDiffer) {
  const TempFolder folder;
  const std::string path = (folder / "a.tif").string();
  ASSERT_EQ(
      runCommand("/usr/bin/python3 -c \"import numpy as n, tifffile as t; w = t.TiffWriter('" +
                 path + "'); w.write(n.zeros((5, 4), 'u1')); w.write(n.zeros((5, 6), 'u1'))\"")
          .status,
      0);
  EXPECT_THAT(errorOf([&] { openSlices({path}); }), HasSubstr("page 2 is 6 x 5"));
}

TEST_F(Slices, rejectKindsThatAreNotUnderstood) {
  const TempFolder folder;
  const auto write = [&](const std::string& file, const std::string& array,
                         const std::string& options) {
    ASSERT_EQ(runCommand("/usr/bin/python3 -c \"import numpy as n, tifffile as t; t.imwrite('" +
                         (folder / file).string() + "', " + array + ", " + options + ")\"")
                  .status,
              0);
  };
  write("complex.tif", "n.zeros((4, 4), 'c8')", "photometric='minisblack'");
  write("half.tif", "n.zeros((4, 4), 'f2')", "photometric='minisblack'");
  write("planes.tif", "n.zeros((3, 4, 4), 'u1')", "photometric='rgb', planarconfig='separate'");
  write("wide.tif", "n.zeros((4, 4), 'u8')", "photometric='minisblack'");
  for (const char* file : {"complex.tif", "half.tif", "planes.tif", "wide.tif"})
    EXPECT_THAT(errorOf([&] { openSlices({folder / file}); }), HasSubstr("expected grey of 8, 16"))
        << file;
}

TEST_F(Slices, surviveDamage) {
  const TempFolder folder;
  for (const char* name : {"png-vtk-u16", "png-palette-4-bit", "png-interlaced-16", "tiff-u16",
                           "tiff-strips", "tiff-zlib-predictor", "tiff-tiles", "tiff-tiles-zlib",
                           "tiff-palette", "tiff-vtk-packbits", "tiff-bigtiff", "tiff-pages"}) {
    SCOPED_TRACE(name);
    const int accepted = surviveDamage(firstOf(name), folder / "bad", 150, 0, [](const auto& path) {
      const auto source = openSlices({path});
      const Vec3i dims = source->layout().dims;
      // A damaged header may ask for a picture of any size: see a part of it.
      readBox(*source, boxOf(min(dims, Vec3i{200, 200, 3})));
      const Vec3i last = dims - Vec3i{1, 1, 1};
      readBox(*source, {last, dims});
    });
    EXPECT_EQ(accepted, 0);
  }
}

// Every stream that zlib wrote carries a checksum of its decoded bytes.
TEST_F(Slices, aFlippedBitOfACompressedPictureIsAnErrorOrChangesNothing) {
  const TempFolder folder;
  int files = 0;
  for (const Case& c : cases_) {
    if (!std::filesystem::exists(pathOf(c.name + ".streams"))) continue;
    ++files;
    SCOPED_TRACE(c.name);
    const std::string sound = readFile(firstOf(c.name));
    const std::string expected = asText(readAll(*openSlices({firstOf(c.name)})));
    std::istringstream streams(readFile(pathOf(c.name + ".streams")));
    int tried = 0, refused = 0;
    for (size_t first = 0, end = 0; streams >> first >> end;) {
      // Every bit of the checksum, and some of the others.
      constexpr size_t kChecksumBits = 32;
      const size_t checksum = std::max(first * 8, end * 8 - kChecksumBits);
      for (size_t bit = first * 8; bit < end * 8; bit += bit + 61 < checksum ? 61 : 1) {
        std::string damaged = sound;
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
        writeFile(folder / "bad", damaged);
        ++tried;
        try {
          const auto source = openSlices({folder / "bad"});
          ASSERT_TRUE(asText(readAll(*source)) == expected) << "bit " << bit;
        } catch (const Error& error) {
          ++refused;
          ASSERT_THAT(error.what(), HasSubstr("bad: ")) << bit;
        }
      }
    }
    EXPECT_GT(refused, tried * 9 / 10);
  }
  EXPECT_EQ(files, 9);
}

// Rows and decoders stay within their limit, and are still read right.
TEST_F(Slices, holdNoMoreThanTheyMay) {
  for (const char* name : {"png-vtk-u16", "tiff-one-strip-zlib"}) {
    const auto source = openSliceFolder(pathOf(name));
    EXPECT_GT(source->heldBytesAThread(), 2 * 53U * 70 * 2);
    source->holdAtMost(1);
    EXPECT_TRUE(asText(readAll(*source)) == voxelsOf(name));
    source->holdAtMost(1 << 20);
    EXPECT_TRUE(asText(readAll(*source)) == voxelsOf(name));
  }
}

TEST(SliceFolder, missingNumbersAreNamed) {
  const TempFolder folder;
  for (const int n : {48, 49, 51, 52, 53, 54})
    writePng(folder / fmt::format("s{:04}.png", n), {4, 3, std::vector<uint8_t>(48, 1)});
  EXPECT_THAT(openSliceFolder(folder.path())->layout().notes,
              testing::Contains(HasSubstr("s0050.png is missing")));
  std::filesystem::remove(folder / "s0049.png");
  EXPECT_THAT(openSliceFolder(folder.path())->layout().notes,
              testing::Contains(HasSubstr("s0049.png and s0050.png are missing")));
  std::filesystem::remove(folder / "s0048.png");
  EXPECT_THAT(openSliceFolder(folder.path())->layout().notes,
              Not(testing::Contains(HasSubstr("missing"))));
}

TEST(SliceFolder, piecesWithoutAHeaderAreSlicesWhereDimsAndTypeAreGiven) {
  const TempFolder folder;
  for (const int n : {2, 10, 9})
    writeFile(folder / fmt::format("p{}", n), fmt::format("{:02}34", n));
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }),
              AllOf(HasSubstr("3 files of 4 bytes each"), HasSubstr("--dims X,Y,3 and --type")));
  OpenOptions options{.dims = Vec3i{2, 2, 3}, .type = VoxelType::kU8};
  for (const std::string& input :
       {folder.path().string(), (folder / "p%d").string(), (folder / "p*").string()}) {
    const auto source = openVolume(input, options);
    EXPECT_EQ(source->layout().dims, (Vec3i{2, 2, 3}));
    EXPECT_EQ(asText(readAll(*source)), "023409341034") << input;
    EXPECT_EQ(source->files().size(), 3U);
  }
  options.dims = Vec3i{2, 2, 4};
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string(), options); }),
              HasSubstr("give --dims 2,2,3"));
  options.dims = Vec3i{2, 1, 3};
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string(), options); }),
              HasSubstr("= 2 bytes of a slice expected, 4 found"));
}

TEST(SliceFolder, aSliceThatIsNoFileAnyMoreIsNamed) {
  for (const char* target : {"/dev/zero", "nothing"}) {
    SCOPED_TRACE(target);
    const TempFolder folder;
    for (const int n : {1, 2, 3}) {
      writeFile(folder / fmt::format("p{}.raw", n), "1234");
      writePng(folder / fmt::format("s{}.png", n), {4, 3, std::vector<uint8_t>(48, 1)});
    }
    for (const char* name : {"p2.raw", "s2.png"}) {
      std::filesystem::remove(folder / name);
      std::filesystem::create_symlink(target, folder / name);
    }
    const OpenOptions raw{.dims = Vec3i{2, 2, 3}, .type = VoxelType::kU8};
    for (const char* pattern : {"p%d.raw", "p#.raw", "p*.raw"})
      EXPECT_THAT(errorOf([&] { openVolume((folder / pattern).string(), raw); }),
                  HasSubstr("p2.raw: "))
          << pattern;
    EXPECT_THAT(errorOf([&] { openVolume((folder / "s%d.png").string()); }), HasSubstr("s2.png: "));
    EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }), HasSubstr("s2.png: "));
  }
}

TEST(SliceFolder, rejectsOneWithoutSlicesOrWithTwoKinds) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder.path()); }), HasSubstr("has no slices"));
  writeFile(folder / "step_1.nrrd", "NRRD0004");
  writeFile(folder / "step_2.nrrd", "NRRD0004 ");
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder.path()); }),
              HasSubstr("found step_1.nrrd; give one file, or the files of a time series"));
  std::filesystem::remove(folder / "step_1.nrrd");
  std::filesystem::remove(folder / "step_2.nrrd");
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder / "none"); }), HasSubstr("cannot be read"));
  writeFile(folder / "a.png", "");
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder.path()); }),
              HasSubstr("found neither's first bytes"));
  writeFile(folder / "a.tif", "");
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder.path()); }), HasSubstr("1 PNG and 1 TIFF"));
}

TEST(SliceFolder, rejectsSeveralSeries) {
  const TempFolder folder;
  for (const char* name : {"001.png", "002.png", "head-9.png", "head-10.png", "logo.png"})
    writeFile(folder / name, "");
  EXPECT_THAT(errorOf([&] { openSliceFolder(folder.path()); }),
              AllOf(HasSubstr("2 series of files"), HasSubstr("/%03d.png' (2 files)"),
                    HasSubstr("/head-%d.png' (2 files)")));
}

// Real stacks, compared with another program's voxels.
void expectAsReadByPython(const std::string& folder, const std::string& pattern,
                          const std::string& script, Vec3i dims) {
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is missing";
  if (!hasPythonModules(Case::kModules))
    GTEST_SKIP() << "python3 with " << Case::kModules << " is missing";
  const TempFolder made;
  const std::string raw = (made / "voxels.bin").string();
  const auto run = runCommand("/usr/bin/python3 -c \"" + script + "\" " + shellQuoted(folder) +
                              " " + shellQuoted(raw));
  ASSERT_EQ(run.status, 0) << run.output;
  const auto source = openSlices(expandPattern(folder + "/" + pattern));
  EXPECT_EQ(source->layout().dims, dims);
  EXPECT_EQ(source->layout().type, VoxelType::kU8);
  EXPECT_TRUE(asText(readAll(*source)) == readFile(raw));
}

TEST(SliceFolder, readsTheCtHeadWhosePaletteIsGrey) {
  expectAsReadByPython(SLUICE_DATA_DIR "/cthead", "%03d.tif", R"(
import sys, tifffile
out = open(sys.argv[2], 'wb')
for n in range(1, 100):
    page = tifffile.TiffFile(f'{sys.argv[1]}/{n:03}.tif').pages[0]
    out.write((page.colormap[1][page.asarray()] >> 8).astype('u1').tobytes()))",
                       {256, 256, 99});
}

TEST(SliceFolder, readsTheVisibleFemaleWithUnpaddedNumbers) {
  expectAsReadByPython(SLUICE_DATA_DIR "/visible-female-head", "*.png", R"(
import sys
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.util.numpy_support import vtk_to_numpy
out = open(sys.argv[2], 'wb')
for n in range(234):
    reader = vtkPNGReader()
    reader.SetFileName(f'{sys.argv[1]}/texture-{n}.png')
    reader.Update()
    out.write(vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(512, 512)[::-1].tobytes()))",
                       {512, 512, 234});
}

TEST(SliceStack, aPageOfSeveralPlanesIsRefused) {
  if (!hasPythonModules("numpy, tifffile")) GTEST_SKIP() << "python3 with tifffile is missing";
  const TempFolder folder;
  const std::string file = (folder / "deep.tif").string();
  ASSERT_EQ(
      runCommand("/usr/bin/python3 -c \"import numpy as n, tifffile as t; t.imwrite('" + file +
                 "', n.zeros((32, 32, 48), 'u1'), photometric='minisblack', "
                 "tile=(16, 16, 16), volumetric=True)\"")
          .status,
      0);
  EXPECT_THAT(errorOf([&] { openVolume(file); }), testing::HasSubstr("a page of 32 planes"));
}

}  // namespace
}  // namespace sluice
