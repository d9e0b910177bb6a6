#include "io/zarr/packing/zarr_writer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <thread>

#include "io/zarr/packing/zarr_pack_folder.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/image_test_support.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice::zarr_writer_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::SizeIs;

PackReport pack(VolumeSource& source, const fs::path& output, const PackOptions& options,
                int threads = 3) {
  WorkerPool pool(threads);
  ProgressMeter progress;
  return packZarr(source, output, options, pool, progress);
}

CheckReport check(const fs::path& folder) {
  WorkerPool pool(2);
  ProgressMeter progress;
  return checkZarr(folder, pool, progress);
}

void flipBit(const fs::path& path, size_t at) {
  std::string bytes = readFile(path);
  bytes[at] = static_cast<char>(bytes[at] ^ 4);
  writeFile(path, bytes);
}

// Odd sizes, so that chunks stick out; noise in one half and nothing in the other.
std::unique_ptr<FunctionSource> halfNoise(VolumeLayout layout) {
  layout.name = "half";
  return std::make_unique<FunctionSource>(layout, [=](int64_t t, Vec3i at) -> double {
    if (at.x >= 32) return 0;
    const int64_t hash = (at.x * 7919 + at.y * 104729 + at.z * 1299709 + t * 31) % 100;
    return layout.type == VoxelType::kI8 ? static_cast<double>(hash - 50)
                                         : static_cast<double>(hash);
  });
}
constexpr Vec3i kDims{70, 45, 37};
const PackOptions kSmall{.chunk_voxels = 16};

std::unique_ptr<FunctionSource> halfNoise(VoxelType type = VoxelType::kU8, int64_t steps = 1) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.type = type;
  layout.time_steps = steps;
  return halfNoise(layout);
}

void expectEqualVoxels(VolumeSource& packed, VolumeSource& source) {
  ASSERT_EQ(packed.layout().dims, source.layout().dims);
  ASSERT_EQ(packed.layout().type, source.layout().type);
  ASSERT_EQ(packed.layout().time_steps, source.layout().time_steps);
  for (int64_t t = 0; t < source.layout().time_steps; ++t)
    EXPECT_TRUE(readAll(packed, t) == readAll(source, t)) << "step " << t;
}

TEST(PackZarr, everyTypeAndCodecReadsBackEqual) {
  const TempFolder folder;
  for (const char* type : {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"}) {
    for (const BloscCodec codec : {BloscCodec::kLz4, BloscCodec::kZstd}) {
      SCOPED_TRACE(type);
      const auto source = halfNoise(*parseVoxelType(type), 2);
      PackOptions options = kSmall;
      options.blosc.codec = codec;
      options.verify = true;
      options.replace = true;
      const PackReport report = pack(*source, folder / "v.zarr", options);
      EXPECT_EQ(report.chunks, 2 * 5 * 3 * 3);
      EXPECT_EQ(report.empty_chunks, 2 * 3 * 3 * 3);
      ZarrSource packed(folder / "v.zarr");
      EXPECT_TRUE(packed.hasChecksums());
      expectEqualVoxels(packed, *source);
      EXPECT_THAT(check(folder / "v.zarr").faults, SizeIs(0));
      EXPECT_FALSE(fs::exists(folder / "v.zarr.partial"));
    }
  }
}

TEST(PackZarr, placeDirectionsAndScalingAreKeptToTheBit) {
  const TempFolder folder;
  VolumeLayout layout;
  layout.dims = {5, 6, 7};
  layout.type = VoxelType::kI16;
  layout.spacing = {0.1, 1.0 / 3, 2.7e-5};
  layout.origin = {-17.3, 1e7, 0.1 + 0.2};
  const double c = std::cos(0.3), s = std::sin(0.3);
  layout.axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, -1}}};
  layout.value_scale = 0.7;
  layout.value_offset = -1024.5;
  layout.unit = "micrometer";
  pack(*halfNoise(layout), folder / "v.zarr", {});
  const ZarrSource packed(folder / "v.zarr");
  EXPECT_EQ(packed.layout().spacing, layout.spacing);
  EXPECT_EQ(packed.layout().origin, layout.origin);
  EXPECT_EQ(packed.layout().axes, layout.axes);
  EXPECT_EQ(packed.layout().value_scale, layout.value_scale);
  EXPECT_EQ(packed.layout().value_offset, layout.value_offset);
  EXPECT_EQ(packed.layout().unit, "micrometer");
}

// The source's background is the fill value: empty chunks are never read and have no file.
TEST(PackZarr, theBackgroundOfASparseSourceCostsNothing) {
  const TempFolder folder;
  VolumeLayout layout;
  layout.dims = {64, 64, 64};
  layout.type = VoxelType::kF32;
  layout.name = "surface (level set)";
  FunctionSource source(
      layout,
      [](int64_t, Vec3i at) {
        return at.x < 16 && at.y < 16 && at.z < 16 ? 1.0 * static_cast<double>(at.x) : 2.5;
      },
      Occupancy{2.5, {{{0, 0, 0}, {16, 16, 16}}}});
  const PackReport report = pack(source, folder / "v.zarr", kSmall);
  EXPECT_EQ(report.chunks - report.empty_chunks, 1);
  EXPECT_EQ(source.storedBytesRead(), 64U * 64 * 16 * 4);
  ZarrSource packed(folder / "v.zarr");
  EXPECT_EQ(packed.layout().name, "v.zarr (level set)");
  const auto occupancy = packed.occupancy(0);
  ASSERT_TRUE(occupancy.has_value());
  EXPECT_EQ(occupancy->background, 2.5);
  EXPECT_EQ(occupancy->boxes, (std::vector<Box3>{{{0, 0, 0}, {16, 16, 16}}}));
  expectEqualVoxels(packed, source);
}

TEST(PackZarr, zarrPythonFindsEveryVoxelEqual) {
  if (!hasPythonModules("numpy, zarr, numcodecs"))
    GTEST_SKIP() << "python3 with numpy, zarr and numcodecs is missing";
  const TempFolder folder;
  const std::map<std::string, std::string> types = {
      {"u8", "u1"}, {"i16", "i2"}, {"f32", "f4"}, {"f64", "f8"}};
  for (const auto& [type, numpy] : types)
    for (const int64_t steps : {1, 3})
      for (const BloscCodec codec : {BloscCodec::kLz4, BloscCodec::kZstd}) {
        const auto source = halfNoise(*parseVoxelType(type), steps);
        PackOptions options = kSmall;
        options.blosc.codec = codec;
        options.replace = true;
        pack(*source, folder / "v.zarr", options);
        std::string all;
        for (int64_t t = 0; t < steps; ++t) {
          const auto bytes = readAll(*source, t);
          all.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        }
        writeFile(folder / "v.bin", all);
        const auto result = runCommand(fmt::format(
            "/usr/bin/python3 -c 'import zarr, numpy as np; g = zarr.open(\"{0}/v.zarr\", \"r\"); "
            "a = g[g.attrs[\"multiscales\"][0][\"datasets\"][0][\"path\"]]; "
            "v = np.fromfile(\"{0}/v.bin\", \"{1}\").reshape(a.shape); "
            "axes = \"\".join(x[\"name\"] for x in g.attrs[\"multiscales\"][0][\"axes\"]); "
            "assert a.dtype == v.dtype and (a[...] == v).all(); print(axes, a.shape)'",
            folder.path().string(), numpy));
        EXPECT_EQ(result.output, steps == 1 ? "zyx (37, 45, 70)\n" : "tzyx (3, 37, 45, 70)\n");
      }
}

TEST(PackZarr, theBytesAreThoseOfAnyMemoryAndThreads) {
  const TempFolder folder;
  const auto source = halfNoise(VoxelType::kU16, 2);
  pack(*source, folder / "a.zarr", kSmall, 1);
  const auto expected = filesOf(folder / "a.zarr");
  EXPECT_EQ(expected.size(), 2U * 2 * 3 * 3 + 4);  // chunks, three of metadata, checksums
  const uint64_t chunk = 16 * 16 * 16 * 2;
  for (const int threads : {1, 2, 4}) {
    for (const uint64_t memory : {uint64_t{20} * chunk, uint64_t{40} * chunk, uint64_t{1} << 28}) {
      PackOptions options = kSmall;
      options.memory_bytes = memory;
      options.replace = true;
      pack(*source, folder / "b.zarr", options, threads);
      EXPECT_EQ(filesOf(folder / "b.zarr"), expected) << threads << " " << memory;
    }
  }
}

TEST(PackZarr, theLeastMemoryThatAnErrorNamesWorks) {
  const TempFolder folder;
  const auto source = halfNoise();
  PackOptions options = kSmall;
  options.memory_bytes = 1000;
  const std::string line = errorOf([&] { pack(*source, folder / "v.zarr", options); });
  EXPECT_FALSE(fs::exists(folder / "v.zarr.partial"));
  const size_t at = line.find("give --memory ");
  ASSERT_NE(at, std::string::npos) << line;
  options.memory_bytes = std::stoull(line.substr(at + 14));
  pack(*source, folder / "v.zarr", options);
  ZarrSource packed(folder / "v.zarr");
  expectEqualVoxels(packed, *source);
}

TEST(PackZarr, aFailureLeavesNoStoreAndTheNextRunGoesOn) {
  const TempFolder folder;
  const auto source = halfNoise(VoxelType::kU8, 3);
  pack(*source, folder / "whole.zarr", kSmall);
  for (const auto failure : {FailingSource::Failure::kError, FailingSource::Failure::kException}) {
    const fs::path output = folder / "v.zarr";
    // A single thread reads a slab of planes in two pieces; there are 3 slabs a step.
    FailingSource failing(*source, failure, 9);
    EXPECT_ANY_THROW(pack(failing, output, kSmall, 1));
    EXPECT_FALSE(fs::exists(output));
    EXPECT_TRUE(fs::exists(folder / "v.zarr.partial"));
    const PackReport report = pack(*source, output, kSmall);
    EXPECT_EQ(report.kept_chunks, 4 * 15);
    EXPECT_EQ(filesOf(output), filesOf(folder / "whole.zarr"));
    fs::remove_all(output);
  }
}

// A power cut may leave chunks that the journal notes but the disk lacks, and a journal cut
// anywhere.
TEST(PackZarr, whatIsDamagedInAnUnfinishedPackIsDoneAgain) {
  const TempFolder folder;
  const auto source = halfNoise(VoxelType::kU8, 3);
  pack(*source, folder / "whole.zarr", kSmall);
  const fs::path output = folder / "v.zarr", partial = folder / "v.zarr.partial";
  const auto half = [&] {
    fs::remove_all(output);
    FailingSource failing(*source, FailingSource::Failure::kError, 9);
    EXPECT_ANY_THROW(pack(failing, output, kSmall, 1));
  };
  const auto go = [&](int64_t kept) {
    EXPECT_EQ(pack(*source, output, kSmall).kept_chunks, kept);
    EXPECT_EQ(filesOf(output), filesOf(folder / "whole.zarr"));
  };
  half();
  flipBit(partial / "store/0/0/1/1/1", 40);
  go(59);
  half();
  fs::resize_file(partial / "store/0/0/1/1/1", 100);
  fs::remove(partial / "store/0/0/2/0/0");
  go(58);
  half();
  fs::resize_file(partial / "journal", 40 * 10 + 17);
  go(10);
  half();
  flipBit(partial / "journal", 40 * 20 + 9);
  go(20);
  half();
  fs::remove(partial / "journal");
  writeFile(partial / "chunk-0.tmp", "half a chunk");
  go(0);
}

TEST(PackZarr, anUnfinishedPackOfSomethingElseIsLeftAlone) {
  const TempFolder folder;
  const auto source = halfNoise(VoxelType::kU8, 3);
  const fs::path output = folder / "v.zarr";
  FailingSource failing(*source, FailingSource::Failure::kError, 5);
  EXPECT_ANY_THROW(pack(failing, output, kSmall, 1));
  const auto before = filesOf(folder / "v.zarr.partial");
  PackOptions other = kSmall;
  other.blosc.level = 7;
  EXPECT_THAT(
      errorOf([&] { pack(*source, output, other); }),
      AllOf(HasSubstr("v.zarr.partial"), HasSubstr("with other options"), HasSubstr("remove it")));
  EXPECT_THAT(errorOf([&] { pack(*makeWhiteNoise(kDims, VoxelType::kU8, 1), output, kSmall); }),
              HasSubstr("of another volume"));
  EXPECT_EQ(filesOf(folder / "v.zarr.partial"), before);
  fs::create_directories(folder / "w.zarr.partial");
  writeFile(folder / "w.zarr.partial/letter.txt", "dear");
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "w.zarr", kSmall); }),
              HasSubstr("by another program"));
}

TEST(PackZarr, twoAtOnceIsOneLine) {
  const TempFolder folder;
  const auto source = halfNoise();
  FailingSource stalling(*source, FailingSource::Failure::kStall, 1);
  std::jthread first([&] { pack(stalling, folder / "v.zarr", kSmall); });
  stalling.waitUntilStalled();
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "v.zarr", kSmall); }),
              HasSubstr("another sluice is packing"));
  stalling.release();
  first.join();
  ZarrSource packed(folder / "v.zarr");
  expectEqualVoxels(packed, *source);
}

TEST(PackZarr, anExistingOutputIsReplacedOnlyWhenAsked) {
  const TempFolder folder;
  const auto source = halfNoise(), other = halfNoise(VoxelType::kI16);
  pack(*other, folder / "v.zarr", kSmall);
  const auto before = filesOf(folder / "v.zarr");
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "v.zarr", kSmall); }), HasSubstr("--force"));
  PackOptions options = kSmall;
  options.replace = true;
  FailingSource failing(*source, FailingSource::Failure::kError, 3);
  EXPECT_ANY_THROW(pack(failing, folder / "v.zarr", options, 1));
  EXPECT_EQ(filesOf(folder / "v.zarr"), before);
  pack(*source, folder / "v.zarr", options);
  ZarrSource packed(folder / "v.zarr");
  expectEqualVoxels(packed, *source);
  EXPECT_FALSE(fs::exists(folder / "v.zarr.partial"));
  fs::create_directories(folder / "precious.zarr");
  writeFile(folder / "precious.zarr/thesis.txt", "x");
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "precious.zarr", options); }),
              HasSubstr("is no Zarr store"));
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "v.raw", options); }), HasSubstr(".zarr"));
}

// A store, packed, with something wrong.
class PackedDamage : public testing::Test {
 protected:
  PackedDamage() : source_(halfNoise()) { pack(*source_, store_, kSmall); }
  std::string readError() {
    return errorOf([&] {
      ZarrSource packed(store_);
      readAll(packed);
    });
  }
  TempFolder folder_;
  const fs::path store_ = folder_ / "v.zarr";
  const std::unique_ptr<FunctionSource> source_;
};

TEST_F(PackedDamage, anyFlippedBitOfAChunkIsAnErrorThatNamesIt) {
  const fs::path chunk = store_ / "0/1/2/0";
  const std::string sound = readFile(chunk);
  for (size_t at = 0; at < sound.size(); at += 37) {
    flipBit(chunk, at);
    ASSERT_THAT(readError(), AllOf(HasSubstr("0/1/2/0"), HasSubstr("checksum"))) << at;
    writeFile(chunk, sound);
  }
  flipBit(chunk, 99);
  EXPECT_THAT(check(store_).faults, testing::ElementsAre(HasSubstr("0/1/2/0")));
}

TEST_F(PackedDamage, aCutChunkIsAnErrorThatNamesIt) {
  fs::resize_file(store_ / "0/1/2/1", 50);
  EXPECT_THAT(readError(),
              AllOf(HasSubstr("0/1/2/1"), HasSubstr("found 50; the chunk is damaged, copy the "
                                                    "store again or pack it again")));
}

TEST_F(PackedDamage, aMissingChunkIsNotTakenForEmpty) {
  fs::remove(store_ / "0/1/1/1");
  EXPECT_THAT(readError(),
              AllOf(HasSubstr("0/1/1/1"), HasSubstr("was there when the store was packed")));
  EXPECT_THAT(check(store_).faults, testing::ElementsAre(HasSubstr("0/1/1/1")));
}

TEST_F(PackedDamage, aChunkThatWasNotPackedIsFound) {
  fs::copy(store_ / "0/1/1/1", store_ / "0/1/1/4");
  EXPECT_THAT(readError(), HasSubstr("0/1/1/4"));
  EXPECT_THAT(check(store_).faults, testing::ElementsAre(HasSubstr("0/1/1/4")));
}

TEST_F(PackedDamage, anyFlippedBitOfTheChecksumsIsAnError) {
  const fs::path checksums = store_ / "0/.sluice-checksums";
  const std::string sound = readFile(checksums);
  for (size_t at = 0; at < sound.size(); at += 5) {
    flipBit(checksums, at);
    ASSERT_THAT(readError(), HasSubstr(".sluice-checksums")) << at;
    writeFile(checksums, sound);
  }
  for (const size_t length : {size_t{0}, size_t{20}, size_t{48}, sound.size() - 16}) {
    fs::resize_file(checksums, length);
    ASSERT_THAT(readError(), HasSubstr(".sluice-checksums")) << length;
    writeFile(checksums, sound);
  }
  // Gone: the store of another program, which is read unchecked.
  fs::remove(checksums);
  ZarrSource packed(store_);
  EXPECT_FALSE(packed.hasChecksums());
  expectEqualVoxels(packed, *source_);
  EXPECT_THAT(errorOf([&] { check(store_); }), HasSubstr("has no checksums"));
}

TEST_F(PackedDamage, aChangedArrayHeaderIsAnError) {
  const fs::path header = store_ / "0/.zarray";
  std::string text = readFile(header);
  text.replace(text.find("\"fill_value\": 0"), 15, "\"fill_value\": 9");
  writeFile(header, text);
  EXPECT_THAT(readError(), HasSubstr("of another .zarray"));
}

}  // namespace
}  // namespace sluice::zarr_writer_test
