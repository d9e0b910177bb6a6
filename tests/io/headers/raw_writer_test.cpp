#include "io/headers/raw/raw_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "io/synth/synth_source.h"
#include "src/base/error.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/memory_source.h"
#include "tests/support/random_volume.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string textOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::filesystem::path> write(VolumeSource& source, const std::filesystem::path& path,
                                         const VolumeWriteOptions& options = {}) {
  WorkerPool pool(2);
  ProgressMeter quiet;
  return writeVolume(source, path, options, pool, quiet);
}

// Turned and anisotropic, so that a header that forgets something shows it.
std::unique_ptr<MemorySource> turnedVolume(VoxelType type = VoxelType::kI16) {
  VolumeLayout layout;
  layout.dims = {5, 4, 3};
  layout.spacing = {0.5, 1.25, 2};
  layout.origin = {10, -20, 30};
  layout.axes = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  return visitVoxelType(type, [&](auto tag) {
    using T = decltype(tag);
    return makeMemorySource<T>(layout, [](auto x, auto y, auto z) { return x + 7 * y + 31 * z; });
  });
}

TEST(RawWriter, rawHoldsTheVoxelsAlone) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({17, 13, 11}, VoxelType::kU16, 3);
  EXPECT_THAT(write(*source, folder / "a.raw"), ElementsAre(folder / "a.raw"));
  EXPECT_EQ(readFile(folder / "a.raw"), textOf(source->bytes()));
}

TEST(RawWriter, smallBuffersGiveTheSameFile) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({17, 13, 11}, VoxelType::kU16, 3);
  // A few planes, a few rows, less than a row, less than a voxel.
  for (const uint64_t bytes : {1000, 100, 20, 1}) {
    CountingSource counting(*source);
    VolumeWriteOptions options;
    options.buffer_bytes = bytes;
    write(counting, folder / "a.raw", options);
    EXPECT_EQ(readFile(folder / "a.raw"), textOf(source->bytes())) << bytes;
    EXPECT_EQ(counting.counts().voxels, 17 * 13 * 11) << "each voxel read once";
    for (const CountingSource::Read& read : counting.reads())
      EXPECT_LE(read.box.count() * 2, std::max<int64_t>(2, static_cast<int64_t>(bytes)));
  }
}

TEST(RawWriter, whatItWillMakeIsKnownBefore) {
  const TempFolder folder;
  BlobOptions blobs;
  blobs.time_steps = 2;
  const auto source = makeSparseBlobs(blobs);
  for (const char* name : {"a.raw", "b.nrrd", "c.nhdr", "d_##.mhd", "E.RAW"})
    EXPECT_EQ(write(*source, folder / name), filesToWrite(source->layout(), folder / name)) << name;
  EXPECT_THROW(filesToWrite(source->layout(), "a.png"), Error);
}

TEST(RawWriter, stepsAreFilesOfTheirOwn) {
  const TempFolder folder;
  BlobOptions blobs;
  blobs.time_steps = 3;
  const auto source = makeSparseBlobs(blobs);
  EXPECT_THAT(write(*source, folder / "a.raw"),
              ElementsAre(folder / "a_000.raw", folder / "a_001.raw", folder / "a_002.raw"));
  const auto all = textOf(source->bytes());
  EXPECT_EQ(readFile(folder / "a_001.raw"), all.substr(all.size() / 3, all.size() / 3));
  EXPECT_THAT(write(*source, folder / "t%02dx.raw"),
              ElementsAre(folder / "t00x.raw", folder / "t01x.raw", folder / "t02x.raw"));
  EXPECT_THAT(write(*source, folder / "%d.raw"),
              ElementsAre(folder / "0.raw", folder / "1.raw", folder / "2.raw"));
  for (const char* name :
       {"%s.raw", "%d%d.raw", "%999d.raw", "%.raw", "%-1d.raw", "##_#.raw", "#%d.raw"})
    EXPECT_THROW(write(*source, folder / name), Error) << name;
}

TEST(RawWriter, zerosBecomeHoles) {
  const TempFolder folder;
  // 2^31 voxels and more: a slab of one plane in the middle.
  const SynthOptions options = parseSynthSpec("slab,dims=1300x1300x1301,share=0.0005");
  const auto source = openSynth(options);
  CountingSource counting(*source);
  write(counting, folder / "a.raw");
  struct stat status {};
  ASSERT_EQ(stat((folder / "a.raw").c_str(), &status), 0);
  EXPECT_EQ(status.st_size, int64_t{1300} * 1300 * 1301);
  EXPECT_LT(status.st_blocks * 512, int64_t{1300} * 1300 * 3);
  EXPECT_LT(counting.counts().voxels, 100'000'000) << "what is known to be zero is not computed";
  std::vector<uint8_t> plane(1300 * 1300);
  source->readRegion(0, {{0, 0, 650}, {1300, 1300, 651}}, std::as_writable_bytes(std::span(plane)));
  FILE* file = fopen((folder / "a.raw").c_str(), "rb");
  ASSERT_NE(file, nullptr);
  std::vector<uint8_t> written(plane.size());
  fseeko(file, off_t{650} * 1300 * 1300, SEEK_SET);
  ASSERT_EQ(fread(written.data(), 1, written.size(), file), written.size());
  fclose(file);
  EXPECT_EQ(written, plane);
}

TEST(RawWriter, holesReadAsTheZerosTheyReplace) {
  const TempFolder folder;
  const auto source = openSynth(parseSynthSpec("sparse,dims=200x160x120,share=0.05"));
  std::vector<std::byte> voxels(200 * 160 * 120);
  source->readRegion(0, boxOf({200, 160, 120}), voxels);
  VolumeWriteOptions options;
  write(*source, folder / "a.nrrd", options);
  options.holes = false;
  write(*source, folder / "b.nrrd", options);
  const std::string with = readFile(folder / "a.nrrd");
  EXPECT_EQ(with, readFile(folder / "b.nrrd"));
  EXPECT_EQ(with.substr(with.size() - voxels.size()), textOf(voxels));
}

TEST(RawWriter, failureLeavesNothing) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({32, 32, 32}, VoxelType::kU8, 3);
  FailingSource failing(*source, FailingSource::Failure::kError, 5);
  VolumeWriteOptions options;
  options.buffer_bytes = 2048;
  for (const char* name : {"a.raw", "a.nrrd", "a.mhd", "a.nhdr"}) {
    FailingSource fails(*source, FailingSource::Failure::kError, 5);
    EXPECT_THROW(write(fails, folder / name, options), Error) << name;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << name;
  }
}

TEST(RawWriter, refusesWhatItCannotWrite) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({2, 2, 2}, VoxelType::kU8, 3);
  EXPECT_THROW(write(*source, folder / "a.tif"), Error);
  EXPECT_THROW(write(*source, folder / "a"), Error);
  EXPECT_THROW(write(*source, folder / "no" / "a.raw"), Error);
}

// teem reads it: voxels, directions, origin.
TEST(RawWriter, nrrdIsReadByTeem) {
  if (!haveProgram("teem-unu")) GTEST_SKIP() << "teem-unu (teem-apps) is not installed";
  const TempFolder folder;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI8, VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kU32, VoxelType::kI32, VoxelType::kF32, VoxelType::kF64})
    for (const char* name : {"a.nrrd", "a.nhdr"}) {
      const auto source = turnedVolume(type);
      write(*source, folder / name);
      const std::string file = shellQuoted((folder / name).string());
      EXPECT_EQ(runCommand("cat " + file + " | head -c 8").output, "NRRD0004");
      EXPECT_EQ(runCommand("teem-unu data " + file).output, textOf(source->bytes()))
          << sluice::name(type) << ' ' << name;
      const std::string head = runCommand("cd " + shellQuoted(folder.path().string()) +
                                          " && teem-unu save -f nrrd -e ascii -i " + name)
                                   .output;
      EXPECT_THAT(head, HasSubstr("sizes: 5 4 3"));
      EXPECT_THAT(head, HasSubstr("space directions: (0,0.5,0) (-1.25,0,0) (0,0,2)"));
      EXPECT_THAT(head, HasSubstr("space origin: (10,-20,30)"));
    }
}

TEST(RawWriter, metaImageIsReadByVtk) {
  if (runCommand("/usr/bin/python3 -c 'import vtkmodules'").status != 0)
    GTEST_SKIP() << "python3-vtk9 is not installed";
  const TempFolder folder;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kU32, VoxelType::kF32}) {
    const auto source = turnedVolume(type);
    EXPECT_THAT(write(*source, folder / "a.mhd"), ElementsAre(folder / "a.mhd", folder / "a.raw"));
    writeFile(folder / "read.py",
              "import sys\n"
              "from vtkmodules.vtkIOImage import vtkMetaImageReader\n"
              "r = vtkMetaImageReader(); r.SetFileName(sys.argv[1]); r.Update()\n"
              "i = r.GetOutput(); s = i.GetPointData().GetScalars()\n"
              "print(i.GetDimensions(), i.GetSpacing(), i.GetOrigin(),\n"
              "      all(s.GetTuple1(x + 5 * (y + 4 * z)) == x + 7 * y + 31 * z\n"
              "          for z in range(3) for y in range(4) for x in range(5)))\n");
    const CommandResult result = runCommand("/usr/bin/python3 " + (folder / "read.py").string() +
                                            " " + (folder / "a.mhd").string());
    EXPECT_EQ(result.output, "(5, 4, 3) (0.5, 1.25, 2.0) (10.0, -20.0, 30.0) True\n") << name(type);
  }
  EXPECT_THAT(readFile(folder / "a.mhd"), HasSubstr("TransformMatrix = 0 1 0 -1 0 0 0 0 1\n"));
}

}  // namespace
}  // namespace sluice
