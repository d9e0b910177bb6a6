#include "io/headers/raw/raw.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "tests/io/headers/volume_files.h"

namespace sluice::raw_test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

constexpr Vec3i kDims{5, 4, 3};

TEST(RawTest, opensFromTheNameAlone) {
  const TempFolder folder;
  const auto path = folder.write("a_5x4x3_int16.raw", knownVoxels(VoxelType::kI16, kDims));
  const auto source = openRaw(path);
  expectKnownVolume(*source, VoxelType::kI16, kDims);
  EXPECT_EQ(source->layout().name, "a_5x4x3_int16.raw");
  EXPECT_EQ(source->storedBytesRead(), 5U * 4 * 3 * 2);
}

TEST(RawTest, optionsWinOverTheName) {
  const TempFolder folder;
  const std::string voxels = swapped(knownVoxels(VoxelType::kF32, kDims, 2), VoxelType::kF32);
  const auto path = folder.write("a_9x9x9x9_uint8.raw", "1234567" + voxels);
  RawOptions options;
  options.dims = kDims;
  options.time_steps = 2;
  options.type = VoxelType::kF32;
  options.byte_order = std::endian::big;
  options.skip_bytes = 7;
  options.spacing = Vec3d{1, 2, 0.5};
  const auto source = openRaw(path, options);
  expectKnownVolume(*source, VoxelType::kF32, kDims, 2);
  EXPECT_TRUE(source->layout().spacing == (Vec3d{1, 2, 0.5}));
}

TEST(RawTest, readsAGzippedFile) {
  SLUICE_NEEDS("gzip", "gzip --version");
  const TempFolder folder;
  const auto path = folder.write("a_5x4x3_uint16.raw", knownVoxels(VoxelType::kU16, kDims));
  ASSERT_TRUE(runs("gzip " + path.string()));
  expectKnownVolume(*openRaw(folder / "a_5x4x3_uint16.raw.gz"), VoxelType::kU16, kDims);
}

TEST(RawTest, identityNamesFileAndSelection) {
  const TempFolder folder;
  const auto path = folder.write("a_5x4x3_uint8.raw", std::string(60, 'a'));
  RawOptions options;
  options.dims = Vec3i{4, 5, 3};
  EXPECT_THAT(openRaw(path)->identity(), EndsWith("|5x4x3x1 u8 le skip 0"));
  EXPECT_THAT(openRaw(path, options)->identity(), EndsWith("|4x5x3x1 u8 le skip 0"));
  EXPECT_THAT(openRaw(path)->identity(), HasSubstr(path.string() + "|60|"));
}

TEST(RawTest, aWrongSizeShowsTheArithmetic) {
  const TempFolder folder;
  const auto path = folder.write("engine_256x256x128_uint8.raw", "");
  std::filesystem::resize_file(path, 8388000);
  EXPECT_THAT(errorOf([&] { openRaw(path); }),
              EndsWith("engine_256x256x128_uint8.raw: 256 x 256 x 128 x 1 byte (u8) + 0 skipped = "
                       "8388608 bytes expected, 8388000 found; give --dims, --type or --skip"));
  std::filesystem::resize_file(path, 8388609);
  EXPECT_THAT(errorOf([&] { openRaw(path); }), HasSubstr("8388608 bytes expected, 8388609 found"));
}

TEST(RawTest, wholeTimeStepsTooManySuggestFourNumbers) {
  const TempFolder folder;
  const auto path = folder.write("a_5x4x3_uint8.raw", std::string(600, 'a'));
  EXPECT_THAT(errorOf([&] { openRaw(path); }),
              EndsWith("60 bytes expected, 600 found; these are 10 time steps: give "
                       "--dims 5,4,3,10"));
  RawOptions options;
  options.dims = kDims;
  options.time_steps = 10;
  EXPECT_EQ(openRaw(path, options)->layout().time_steps, 10);
}

TEST(RawTest, aMissingTypeSaysWhichWouldFit) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openRaw(folder.write("a_5x4x3.raw", std::string(60, 'a'))); }),
              EndsWith("60 bytes / (5 x 4 x 3 x 1 steps) = 1 bytes a voxel: give --type u8 or i8"));
  EXPECT_THAT(errorOf([&] { openRaw(folder.write("b_5x4x3.raw", std::string(240, 'a'))); }),
              EndsWith("give --type u32 or i32 or f32"));
  EXPECT_THAT(errorOf([&] { openRaw(folder.write("c_5x4x3.raw", std::string(90, 'a'))); }),
              EndsWith("= 1.5 bytes a voxel: no type fits, --dims or --skip is wrong"));
  EXPECT_THAT(errorOf([&] { openRaw(folder.write("d.raw", "12")); }),
              HasSubstr("give --dims X,Y,Z"));
}

TEST(RawTest, rejectsOptionsThatMakeNoSense) {
  const TempFolder folder;
  const auto path = folder.write("a_5x4x3_uint8.raw", std::string(60, 'a'));
  const auto error = [&](const std::function<void(RawOptions&)>& change) {
    RawOptions options;
    change(options);
    return errorOf([&] { openRaw(path, options); });
  };
  EXPECT_THAT(error([](RawOptions& o) { o.dims = Vec3i{0, 4, 3}; }), HasSubstr("1 or more"));
  EXPECT_THAT(error([](RawOptions& o) { o.dims = Vec3i{-5, -4, 3}; }), HasSubstr("1 or more"));
  EXPECT_THAT(error([](RawOptions& o) {
                o.dims = Vec3i{1LL << 40, 1LL << 40, 1};
              }),
              HasSubstr("do not fit 2^62 bytes"));
  EXPECT_THAT(error([](RawOptions& o) {
                o.dims = kDims;
                o.time_steps = 0;
              }),
              HasSubstr("1 or more"));
  EXPECT_THAT(error([](RawOptions& o) { o.skip_bytes = -1; }), HasSubstr("--skip -1"));
  EXPECT_THAT(error([](RawOptions& o) { o.skip_bytes = INT64_MAX; }), HasSubstr("--skip"));
  EXPECT_THAT(error([](RawOptions& o) { o.skip_bytes = 60; }), HasSubstr("120 bytes expected"));
  EXPECT_THAT(error([](RawOptions& o) { o.spacing = Vec3d{1, 0, 1}; }), HasSubstr("--spacing"));
  EXPECT_THAT(error([](RawOptions& o) { o.spacing = Vec3d{1, NAN, 1}; }), HasSubstr("--spacing"));
  EXPECT_THAT(error([](RawOptions& o) { o.spacing = Vec3d{1, 1e300, 1}; }), HasSubstr("spacing"));
}

TEST(RawTest, aVolumeOfMoreThanTwoToThe31VoxelsIsReadRightAtBothEnds) {
  const TempFolder folder;
  const Vec3i dims{2048, 2048, 520};
  const int64_t bytes = volume(dims) * 2;
  ASSERT_GT(volume(dims), int64_t{1} << 31);
  const auto path = folder.write("big_2048x2048x520_uint16.raw", "AB");
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(bytes - 6);
    file << "CDEFGH";
  }
  const auto source = openRaw(path);
  const auto text = [&](const Box3& box) {
    const std::vector<std::byte> voxels = readBox(*source, 0, box);
    return std::string(reinterpret_cast<const char*>(voxels.data()), voxels.size());
  };
  EXPECT_EQ(text({{0, 0, 0}, {2, 1, 1}}), std::string("AB\0\0", 4));
  EXPECT_EQ(text({{2044, 2047, 519}, {2048, 2048, 520}}), std::string("\0\0CDEFGH", 8));
}

TEST(RawTest, threadsMayReadAtOnce) {
  const TempFolder folder;
  const Vec3i dims{64, 64, 32};
  const std::string voxels = knownVoxels(VoxelType::kU8, dims);
  const auto source = openRaw(folder.write("a_64x64x32_uint8.raw", voxels));
  std::vector<std::jthread> threads;
  threads.reserve(4);
  std::atomic<int> wrong{0};
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int z = 0; z < 32; ++z) {
        const auto plane = readBox(*source, 0, {{0, 0, z}, {64, 64, z + 1}});
        wrong += std::memcmp(plane.data(), voxels.data() + z * 4096, 4096) != 0;
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(source->storedBytesRead(), 4 * voxels.size());
}

}  // namespace
}  // namespace sluice::raw_test
