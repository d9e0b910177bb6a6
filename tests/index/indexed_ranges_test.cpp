#include "src/index/indexed_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <set>

#include "io/headers/raw/raw.h"
#include "io/synth/synth_source.h"
#include "src/base/error.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/support/temp_folder.h"

namespace sluice::indexed_ranges_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// A raw file in a folder of its own, and a separate cache folder.
class IndexedRangesTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "data");
    path_ = folder_ / "data" / "blobs_30x25x20_uint8.raw";
    writeVoxels(1);
  }
  void writeVoxels(uint64_t seed) {
    BlobOptions options;
    options.dims = {30, 25, 20};
    options.seed = seed;
    const auto source = makeSparseBlobs(options);
    const auto bytes = source->bytes();
    writeFile(path_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  std::unique_ptr<VolumeSource> open(std::optional<Vec3i> dims = std::nullopt) {
    RawOptions options;
    options.dims = dims;
    return openRaw(path_, options);
  }
  IndexedRanges indexed(VolumeSource& source, int64_t size = 8, int ghost = 0) {
    WorkerPool pool(2);
    ProgressMeter quiet;
    return indexedRanges(source, indexPlaces(path_.string(), wish_), 0,
                         blockLayout(source.layout().dims, size, ghost), {pool, quiet});
  }
  // The files of a folder and of the folders below it.
  static std::set<std::filesystem::path> filesBelow(const std::filesystem::path& folder) {
    std::set<std::filesystem::path> files;
    if (std::filesystem::exists(folder))
      for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.insert(entry.path());
    return files;
  }
  // The only index there is.
  std::filesystem::path onlyIndex() {
    auto files = filesBelow(folder_.path());
    files.erase(path_);
    EXPECT_EQ(files.size(), 1U);
    return files.empty() ? "" : *files.begin();
  }

  const TempFolder folder_;
  IndexWish wish_{.folder = folder_ / "cache"};
  std::filesystem::path path_;
};

void expectSameRanges(const SliceRanges& a, const SliceRanges& b) {
  EXPECT_EQ(a.background, b.background);
  EXPECT_EQ(a.blocks, b.blocks);
  EXPECT_EQ(a.totals, b.totals);
  EXPECT_EQ(a.planes, b.planes);
  EXPECT_EQ(a.device_range, b.device_range);
  EXPECT_EQ(a.counts, b.counts);
}

TEST_F(IndexedRangesTest, firstOpeningBuildsTheIndexInTheUsersCacheFolder) {
  const auto source = open();
  const IndexedRanges first = indexed(*source);
  EXPECT_EQ(first.origin, IndexOrigin::kBuilt);
  EXPECT_THAT(first.note, IsEmpty());
  EXPECT_NE(first.path.parent_path().parent_path(), path_.parent_path()) << "no litter";
  EXPECT_EQ(first.path, onlyIndex());
}

TEST_F(IndexedRangesTest, secondOpeningReadsNoVoxel) {
  const auto first_source = open();
  const IndexedRanges first = indexed(*first_source);
  const auto second_source = open();
  CountingSource counted(*second_source);
  const IndexedRanges second = indexed(counted);
  EXPECT_EQ(second.origin, IndexOrigin::kRead);
  EXPECT_THAT(second.note, IsEmpty());
  EXPECT_EQ(second.path, first.path);
  EXPECT_EQ(counted.counts().calls, 0);
  expectSameRanges(second.ranges, first.ranges);
}

TEST_F(IndexedRangesTest, changedVolumeIsIndexedAnew) {
  const auto old_source = open();
  const IndexedRanges old = indexed(*old_source);
  writeVoxels(2);
  std::filesystem::last_write_time(
      path_, std::filesystem::last_write_time(path_) + std::chrono::seconds(1));
  const auto source = open();
  const IndexedRanges changed = indexed(*source);
  EXPECT_EQ(changed.origin, IndexOrigin::kBuilt);
  EXPECT_THAT(changed.note, HasSubstr("of another state of the volume"));
  EXPECT_NE(changed.ranges.planes, old.ranges.planes);
  EXPECT_EQ(indexed(*source).origin, IndexOrigin::kRead);
}

TEST_F(IndexedRangesTest, aFileReplacedWithItsTimeRestoredIsIndexedAnew) {
  const auto old_source = open();
  const IndexedRanges old = indexed(*old_source);
  const auto time = std::filesystem::last_write_time(path_);
  writeVoxels(2);
  std::filesystem::last_write_time(path_, time);
  const auto source = open();
  const IndexedRanges changed = indexed(*source);
  EXPECT_EQ(changed.origin, IndexOrigin::kBuilt);
  EXPECT_NE(changed.ranges.planes, old.ranges.planes);
}

TEST_F(IndexedRangesTest, channelsHaveIndicesOfTheirOwn) {
  VolumeLayout layout;
  layout.dims = {12, 12, 12};
  layout.channels = 2;
  WorkerPool pool(2);
  ProgressMeter quiet;
  for (const IndexOrigin origin : {IndexOrigin::kBuilt, IndexOrigin::kRead})
    for (int64_t channel = 0; channel < 2; ++channel) {
      layout.channel = channel;
      FunctionSource source(
          layout, [channel](int64_t, Vec3i p) { return static_cast<double>(p.x * (channel + 1)); });
      const IndexedRanges found = indexedRanges(source, indexPlaces(path_.string(), wish_), 0,
                                                blockLayout(layout.dims, 8, 0), {pool, quiet});
      EXPECT_EQ(found.origin, origin) << channel;
      EXPECT_EQ(found.ranges.device_range.hi, static_cast<double>(11 * (channel + 1)));
    }
}

TEST_F(IndexedRangesTest, damagedIndexIsRebuilt) {
  const auto source = open();
  const IndexedRanges first = indexed(*source);
  std::string bytes = readFile(first.path);
  for (const size_t at : {size_t{3}, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    writeFile(first.path, damaged);
    const IndexedRanges again = indexed(*source);
    EXPECT_EQ(again.origin, IndexOrigin::kBuilt) << at;
    EXPECT_THAT(again.note, HasSubstr(first.path.string())) << at;
    expectSameRanges(again.ranges, first.ranges);
    EXPECT_EQ(readFile(first.path), bytes);
  }
  writeFile(first.path, bytes.substr(0, bytes.size() / 3));
  EXPECT_EQ(indexed(*source).origin, IndexOrigin::kBuilt);
  EXPECT_EQ(indexed(*source).origin, IndexOrigin::kRead);
}

TEST_F(IndexedRangesTest, blockSizesAndGhostLayersHaveIndicesOfTheirOwn) {
  const auto source = open();
  for (const auto& [size, ghost] : {std::pair{8, 0}, {16, 0}, {8, 1}})
    EXPECT_EQ(indexed(*source, size, ghost).origin, IndexOrigin::kBuilt);
  for (const auto& [size, ghost] : {std::pair{8, 0}, {16, 0}, {8, 1}}) {
    const IndexedRanges again = indexed(*source, size, ghost);
    EXPECT_EQ(again.origin, IndexOrigin::kRead);
    EXPECT_EQ(again.ranges.layout.size, size);
    EXPECT_EQ(again.ranges.layout.ghost, ghost);
  }
}

TEST_F(IndexedRangesTest, twoWaysToReadOneFileDoNotPushEachOtherOut) {
  const auto given = open(), turned = open(Vec3i{20, 25, 30});
  EXPECT_EQ(indexed(*given).origin, IndexOrigin::kBuilt);
  EXPECT_EQ(indexed(*turned).origin, IndexOrigin::kBuilt);
  EXPECT_EQ(indexed(*given).origin, IndexOrigin::kRead);
  EXPECT_EQ(indexed(*turned).origin, IndexOrigin::kRead);
  EXPECT_NE(indexed(*given).ranges.blocks, indexed(*turned).ranges.blocks);
}

TEST_F(IndexedRangesTest, timeStepsHaveIndicesOfTheirOwn) {
  VolumeLayout layout;
  layout.dims = {12, 12, 12};
  layout.time_steps = 2;
  FunctionSource source(layout,
                        [](int64_t t, Vec3i p) { return static_cast<double>(p.x * (t + 1)); });
  WorkerPool pool(2);
  const BlockLayout blocks = blockLayout(layout.dims, 8, 0);
  ProgressMeter quiet;
  for (const IndexOrigin origin : {IndexOrigin::kBuilt, IndexOrigin::kRead})
    for (int64_t time = 0; time < 2; ++time) {
      const IndexedRanges found =
          indexedRanges(source, indexPlaces(path_.string(), wish_), time, blocks, {pool, quiet});
      EXPECT_EQ(found.origin, origin) << time;
      EXPECT_EQ(found.ranges.device_range.hi, static_cast<double>(11 * (time + 1)));
    }
}

TEST_F(IndexedRangesTest, anIndexBesideTheVolumeIsStillFound) {
  wish_.beside = true;
  const auto source = open();
  const IndexedRanges built = indexed(*source);
  EXPECT_EQ(built.path.parent_path().string(), path_.string() + ".sluice-index");
  wish_.beside = false;
  const IndexedRanges read = indexed(*source);
  EXPECT_EQ(read.origin, IndexOrigin::kRead);
  EXPECT_EQ(read.path, built.path);
}

TEST_F(IndexedRangesTest, noPlaceAtAllIsNoFailureAndOneShortLine) {
  // A file in the place of the folder: root could write to any folder.
  writeFile(folder_ / "cache", "in the way");
  const auto source = open();
  for (int opening = 0; opening < 2; ++opening) {
    const IndexedRanges built = indexed(*source);
    EXPECT_EQ(built.origin, IndexOrigin::kBuiltNotKept);
    EXPECT_TRUE(built.path.empty());
    EXPECT_THAT(built.note, testing::StartsWith("no index is kept: "));
    EXPECT_THAT(built.note, HasSubstr((folder_ / "cache").string()));
    EXPECT_THAT(built.note, HasSubstr("--index-dir"));
    EXPECT_FALSE(built.ranges.blocks.empty());
  }
}

TEST_F(IndexedRangesTest, theUserMayTurnItOff) {
  wish_.disabled = true;
  const auto source = open();
  const IndexedRanges built = indexed(*source);
  EXPECT_EQ(built.origin, IndexOrigin::kBuiltNotKept);
  EXPECT_THAT(built.note, HasSubstr("SLUICE_INDEX"));
  EXPECT_EQ(filesBelow(folder_.path()), (std::set<std::filesystem::path>{path_}));
}

TEST_F(IndexedRangesTest, syntheticVolumesAreKeptInTheCacheFolder) {
  const std::string spec = "synth:phantom,dims=40x40x40";
  WorkerPool pool(2);
  const auto source = openSynth(parseSynthSpec(spec));
  const BlockLayout layout = blockLayout({40, 40, 40}, 16, 0);
  ProgressMeter quiet;
  const IndexedRanges built =
      indexedRanges(*source, indexPlaces(spec, wish_), 0, layout, {pool, quiet});
  EXPECT_EQ(built.origin, IndexOrigin::kBuilt);
  EXPECT_TRUE(built.path.string().starts_with((folder_ / "cache").string())) << built.path;
  CountingSource counted(*source);
  EXPECT_EQ(indexedRanges(counted, indexPlaces(spec, wish_), 0, layout, {pool, quiet}).origin,
            IndexOrigin::kRead);
  EXPECT_EQ(counted.counts().calls, 0);
}

TEST_F(IndexedRangesTest, failedPassKeepsNothing) {
  const auto source = open();
  FailingSource failing(*source, FailingSource::Failure::kError, 1);
  EXPECT_THROW(indexed(failing), Error);
  EXPECT_EQ(filesBelow(folder_.path()), (std::set<std::filesystem::path>{path_}));
  EXPECT_EQ(indexed(*source).origin, IndexOrigin::kBuilt);
}

}  // namespace
}  // namespace sluice::indexed_ranges_test
