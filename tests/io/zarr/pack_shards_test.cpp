// Stores of Zarr 3 in shards, as sluice packs them.
#include <gmock/gmock.h>

#include <atomic>

#include "io/zarr/packing/zarr_writer.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/image_test_support.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr Vec3i kShardDims{70, 45, 37};
// Two shards along x, one along y and z.
const PackOptions kSharded{.chunk_voxels = 16, .shard_voxels = Vec3i{64, 48, 48}};

PackReport packInShards(VolumeSource& source, const fs::path& output, const PackOptions& options) {
  WorkerPool pool(3);
  ProgressMeter progress;
  return packZarr(source, output, options, pool, progress);
}

CheckReport checkShards(const fs::path& folder) {
  WorkerPool pool(2);
  ProgressMeter progress;
  return checkZarr(folder, pool, progress);
}

// Noise in one half and nothing in the other.
std::unique_ptr<FunctionSource> noiseInHalf(VoxelType type, int64_t steps = 1) {
  VolumeLayout layout;
  layout.dims = kShardDims;
  layout.type = type;
  layout.time_steps = steps;
  layout.spacing = {0.5, 1, 2};
  layout.unit = "micrometer";
  return std::make_unique<FunctionSource>(layout, [](int64_t t, Vec3i at) -> double {
    if (at.x >= 32) return 0;
    return static_cast<double>((at.x * 7919 + at.y * 104729 + at.z * 1299709 + t * 31) % 100);
  });
}

int64_t filesBelow(const fs::path& folder) {
  int64_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    files += entry.is_regular_file();
  return files;
}

TEST(PackShards, everyTypeAndCodecReadsBackEqual) {
  const TempFolder folder;
  for (const char* type : {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"}) {
    for (const BloscCodec codec : {BloscCodec::kLz4, BloscCodec::kZstd}) {
      SCOPED_TRACE(type);
      const auto source = noiseInHalf(*parseVoxelType(type), 2);
      PackOptions options = kSharded;
      options.blosc.codec = codec;
      options.verify = options.replace = true;
      const PackReport report = packInShards(*source, folder / "v.zarr", options);
      EXPECT_EQ(report.chunks, 2 * 5 * 3 * 3);
      EXPECT_EQ(report.empty_chunks, 2 * 3 * 3 * 3);
      EXPECT_EQ(report.files, 2);  // the shards of the other half have no file
      ZarrSource packed(folder / "v.zarr");
      for (int64_t t = 0; t < 2; ++t) EXPECT_TRUE(readAll(packed, t) == readAll(*source, t));
      EXPECT_EQ(packed.layout().spacing, source->layout().spacing);
      EXPECT_EQ(packed.layout().unit, "micrometer");
      EXPECT_THAT(packed.layout().notes, SizeIs(0));
      const CheckReport checked = checkShards(folder / "v.zarr");
      EXPECT_THAT(checked.faults, SizeIs(0));
      EXPECT_EQ(checked.chunks, report.chunks - report.empty_chunks);
      EXPECT_EQ(filesBelow(folder / "v.zarr"), 2 + 2);  // with the metadata of group and array
      EXPECT_FALSE(fs::exists(folder / "v.zarr.partial"));
    }
  }
}

TEST(PackShards, levelsAndSpreadsEqualThoseOfZarr2) {
  const TempFolder folder;
  const auto source = noiseInHalf(VoxelType::kU16);
  PackOptions options = kSharded;
  options.with_levels = true;
  options.levels = 2;
  packInShards(*source, folder / "three.zarr", options);
  options.shard_voxels.reset();
  packInShards(*source, folder / "two.zarr", options);
  ZarrSource three(folder / "three.zarr"), two(folder / "two.zarr");
  ASSERT_EQ(coarserLevels(three).size(), 2U);
  EXPECT_TRUE(readAll(three) == readAll(two));
  for (size_t i = 0; i < 2; ++i) {
    const CoarserLevel &a = coarserLevels(three)[i], &b = coarserLevels(two)[i];
    EXPECT_EQ(a.placement, b.placement);
    EXPECT_TRUE(readAll(*a.source) == readAll(*b.source));
    ASSERT_TRUE(a.spreads != nullptr && b.spreads != nullptr);
    EXPECT_TRUE(readAll(*a.spreads) == readAll(*b.spreads));
  }
  EXPECT_THAT(checkShards(folder / "three.zarr").faults, SizeIs(0));
}

TEST(PackShards, areReadByAnotherReader) {
  if (!hasPythonModules("numpy, numcodecs")) GTEST_SKIP() << "python3 with numcodecs is missing";
  const TempFolder folder;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kF32}) {
    const auto source = noiseInHalf(type);
    PackOptions options = kSharded;
    options.with_levels = options.replace = true;
    options.levels = 1;
    packInShards(*source, folder / "v.zarr", options);
    ZarrSource packed(folder / "v.zarr");
    const CoarserLevel& level = coarserLevels(packed)[0];
    const std::pair<const char*, VolumeSource*> arrays[] = {
        {"0", source.get()}, {"1", level.source}, {"spread/1", level.spreads}};
    for (const auto& [name, expected] : arrays) {
      const auto read = runCommand("/usr/bin/python3 " SLUICE_TEST_DIR "/read_zarr3.py " +
                                   shellQuoted((folder / "v.zarr" / name).string()) + " " +
                                   shellQuoted((folder / "out.bin").string()));
      ASSERT_EQ(read.status, 0) << read.output;
      const std::vector<std::byte> voxels = readAll(*expected);
      EXPECT_TRUE(readFile(folder / "out.bin") ==
                  std::string_view(reinterpret_cast<const char*>(voxels.data()), voxels.size()))
          << name;
    }
  }
}

// Whatever an interrupted run left in a shard, the next one goes on with the chunks that are whole.
TEST(PackShards, goOnAfterAnInterruption) {
  const TempFolder folder;
  VolumeLayout layout = noiseInHalf(VoxelType::kU8)->layout();
  StopSource stop;
  std::atomic<int64_t> asked = 0;
  FunctionSource source(layout, [&](int64_t, Vec3i at) -> double {
    if (++asked == int64_t{70} * 45 * 34) stop.requestStop();
    return static_cast<double>((at.x * 31 + at.y * 17 + at.z * 7) % 251);
  });
  PackOptions options = kSharded;
  options.stop = stop.token();
  EXPECT_THROW(packInShards(source, folder / "v.zarr", options), Interrupted);
  const fs::path shard = folder / "v.zarr.partial/store/0/c/0/0/0";
  ASSERT_TRUE(fs::exists(shard));
  std::string bytes = readFile(shard);
  bytes[10] = static_cast<char>(bytes[10] ^ 1);  // one chunk is damaged
  writeFile(shard, bytes + "left behind");
  options.stop = {};
  options.verify = true;
  const PackReport report = packInShards(source, folder / "v.zarr", options);
  EXPECT_GT(report.kept_chunks, 0);
  EXPECT_LT(report.kept_chunks, 45);
  ZarrSource packed(folder / "v.zarr");
  EXPECT_TRUE(readAll(packed) == readAll(source));
  EXPECT_THAT(checkShards(folder / "v.zarr").faults, SizeIs(0));
}

TEST(PackShards, damageIsFound) {
  const TempFolder folder;
  packInShards(*noiseInHalf(VoxelType::kU8), folder / "v.zarr", kSharded);
  const fs::path shard = folder / "v.zarr/0/c/0/0/0";
  const std::string bytes = readFile(shard);
  for (const auto& [at, what] : {std::pair<size_t, const char*>{20, "a chunk is damaged"},
                                 {bytes.size() - 30, "the index of the shard is damaged"}}) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 8);
    writeFile(shard, changed);
    EXPECT_THAT(checkShards(folder / "v.zarr").faults, ElementsAre(HasSubstr(what)));
    EXPECT_THAT(errorOf([&] {
                  ZarrSource source(folder / "v.zarr");
                  readAll(source);
                }),
                HasSubstr(what));
  }
}

// The index of a shard is read once, and of the chunks those that are needed.
TEST(PackShards, areReadInPart) {
  const TempFolder folder;
  packInShards(*noiseInHalf(VoxelType::kU16), folder / "v.zarr", kSharded);
  ZarrSource source(folder / "v.zarr", {.chunk_cache_bytes = 0});
  const uint64_t metadata = source.storedBytesRead();
  readBox(source, {{0, 0, 0}, {16, 16, 16}});
  const uint64_t index_bytes = 4 * 3 * 3 * 16 + 4, first = source.storedBytesRead() - metadata;
  EXPECT_GT(first, index_bytes);
  EXPECT_LE(first, index_bytes + 16U * 16 * 16 * 2 + 20);
  // The others, each once, and no index again.
  for (int64_t z = 0; z < kShardDims.z; z += 16)
    for (int64_t y = 0; y < kShardDims.y; y += 16)
      for (int64_t x = 0; x < 64; x += 16) {
        if (x + y + z == 0) continue;
        const Vec3i lo{x, y, z};
        readBox(source, intersect({lo, lo + Vec3i{16, 16, 16}}, boxOf(kShardDims)));
      }
  EXPECT_EQ(source.storedBytesRead() - metadata, fs::file_size(folder / "v.zarr/0/c/0/0/0"));
}

TEST(PackShards, takeShardsOfWholeChunks) {
  const TempFolder folder;
  PackOptions options = kSharded;
  options.shard_voxels = Vec3i{64, 40, 48};
  EXPECT_THAT(
      errorOf([&] { packInShards(*noiseInHalf(VoxelType::kU8), folder / "v.zarr", options); }),
      HasSubstr("--shard 64,40,48: expected multiples of the chunks' 16 voxels"));
}

}  // namespace
}  // namespace sluice
