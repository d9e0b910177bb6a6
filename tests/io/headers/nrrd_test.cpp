// NRRD files, read: attached and detached data, and files that teem's unu writes and reads.
#include "io/headers/nrrd/nrrd.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <filesystem>

#include "tests/io/headers/nrrd_headers.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::nrrd_test {
namespace {

using testing::HasSubstr;

TEST(NrrdTest, readsAttachedDetachedAndMultiFileData) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kNrrdDims);
  const std::string big = swapped(voxels, VoxelType::kI16);
  expectKnownVolume(*openNrrd(folder.write("a.nrrd", std::string(kPlainNrrd) + "\n" + voxels)),
                    VoxelType::kI16, kNrrdDims);

  folder.write("b.raw", "line\nxy" + big);
  std::string text = headerWith("endian", "big");
  text.insert(text.size() - 1, "line skip: 1\nbyte skip: 2\ndata file: b.raw\n");
  expectKnownVolume(*openNrrd(folder.write("b.nhdr", text)), VoxelType::kI16, kNrrdDims);

  for (int z = 0; z < 3; ++z)
    folder.write(fmt::format("c{}", z), "front" + voxels.substr(static_cast<size_t>(z) * 40, 40));
  const std::string detached = std::string(kPlainNrrd) + "byte skip: -1\ndata file: ";
  expectKnownVolume(*openNrrd(folder.write("c.nhdr", detached + "c%d 0 2 1\n")), VoxelType::kI16,
                    kNrrdDims);
  expectKnownVolume(*openNrrd(folder.write("d.nhdr", detached + "LIST\nc0\nc1\nc2\n")),
                    VoxelType::kI16, kNrrdDims);
}

TEST(NrrdTest, hundredsOfFilesDoNotUseUpTheDescriptors) {
  const TempFolder folder;
  const Vec3i dims{4, 3, 300};
  const std::string voxels = knownVoxels(VoxelType::kU8, dims);
  for (int z = 0; z < 300; ++z)
    folder.write(fmt::format("s{}", z), voxels.substr(static_cast<size_t>(z) * 12, 12));
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
  const std::string voxels = knownVoxels(VoxelType::kI16, kNrrdDims);
  const auto attached = openNrrd(folder.write("a.nrrd", std::string(kPlainNrrd) + "\n" + voxels));
  const uint64_t header_bytes = attached->storedBytesRead();
  readAll(*attached);
  EXPECT_EQ(attached->storedBytesRead(), header_bytes + voxels.size());

  folder.write("b.raw", voxels);
  const std::string text = std::string(kPlainNrrd) + "data file: b.raw\n";
  const auto detached = openNrrd(folder.write("b.nhdr", text));
  EXPECT_EQ(detached->storedBytesRead(), text.size());
  readAll(*detached);
  EXPECT_EQ(detached->storedBytesRead(), text.size() + voxels.size());
}

TEST(NrrdTest, aFileTooSmallShowsTheArithmetic) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openNrrd(folder.write("a.nrrd", std::string(kPlainNrrd) + "\n123")); }),
              HasSubstr("a.nrrd: 5 x 4 x 3 x 2 bytes (i16) + 77 skipped = 197 bytes expected, 80 "
                        "found"));
  for (const char* name : {"c0", "c1", "c2"}) folder.write(name, std::string(40, 'a'));
  folder.write("c1", "short");
  EXPECT_THAT(
      errorOf([&] {
        openNrrd(folder.write("c.nhdr", std::string(kPlainNrrd) + "data file: c%d 0 2 1\n"));
      }),
      HasSubstr("c1: 5 x 4 x 3 x 2 bytes (i16) / 3 files + 0 skipped = 40 bytes expected, "
                "5 found"));
}

TEST(NrrdTest, aMissingDataFileNamesBoth) {
  const TempFolder folder;
  const std::string line = errorOf(
      [&] { openNrrd(folder.write("a.nhdr", std::string(kPlainNrrd) + "data file: gone.raw\n")); });
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
    folder.write("v.raw", knownVoxels(type, kNrrdDims, 2));
    const std::string make = unu() + " make -i " + (folder / "v.raw").string() + " -t '" +
                             unuType(type) + "' -s 5 4 3 2 -sp 1 2 3 nan -e raw -en little | ";
    for (const char* how : {"-e raw -en little", "-e raw -en big", "-e gzip -en little",
                            "-e gz:9f -en big", "-e ascii"})
      for (const char* file : {"w.nrrd", "w.nhdr"}) {
        const auto path = folder / file;
        ASSERT_TRUE(runs(make + unu() + " save -f nrrd " + how + " -o " + path.string())) << how;
        const auto source = openNrrd(path);
        SCOPED_TRACE(std::string(how) + " " + std::string(name(type)) + " " + file);
        expectKnownVolume(*source, type, kNrrdDims, 2);
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
  folder.write("v", front + knownVoxels(VoxelType::kI16, kNrrdDims));
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
    expectKnownVolume(*openNrrd(header), VoxelType::kI16, kNrrdDims);
    EXPECT_TRUE(voxelsByUnu(folder, header) == knownVoxels(VoxelType::kI16, kNrrdDims));
  }
}

TEST(NrrdPeerTest, readsSeveralFilesAsUnuDoes) {
  SLUICE_NEEDS("teem's unu", kFindUnu);
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kU8, kNrrdDims);
  for (size_t i = 0; i < 12; ++i) folder.write(fmt::format("r{:02}", i), voxels.substr(5 * i, 5));
  for (size_t i = 0; i < 3; ++i) folder.write(fmt::format("p{}", 2 * i), voxels.substr(20 * i, 20));
  const std::string detached = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n";
  for (const char* more :
       {"data file: r%02d 0 11 1 1\n", "data file: p%d 0 4 2\n", "data file: LIST\np0\np2\np4\n",
        "data file: p%d 0 4 2 2\n", "data file: LIST 3\np0\np2\np4\n"}) {
    const auto header = folder.write("h.nhdr", detached + more);
    SCOPED_TRACE(more);
    expectKnownVolume(*openNrrd(header), VoxelType::kU8, kNrrdDims);
    EXPECT_TRUE(voxelsByUnu(folder, header) == voxels);
  }
}

}  // namespace
}  // namespace sluice::nrrd_test
