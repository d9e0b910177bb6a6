// Passes over a volume whose voxels somebody else takes too: the arrays stay what they are, and the
// taker gets each voxel once, as it is stored.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <mutex>

#include "src/base/sources/forwarding_source.h"
#include "src/volume/passes/pass_pieces.h"
#include "src/volume/passes/voxel_pass.h"
#include "src/volume/ranges/brick_ranges.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

// Notes how often each voxel came, and whether it was right.
class NotingTaker final : public VoxelTaker {
 public:
  NotingTaker(VolumeSource& source, int64_t side)
      : source_(source),
        side_(side),
        times_(static_cast<size_t>(volume(source.layout().dims)), 0) {}

  int64_t side() const override { return side_; }
  bool wantsLayer(int64_t z) override {
    EXPECT_EQ(z, ended_);
    return wants;
  }
  void take(const VoxelPiece& piece) override {
    if (!looks) return;
    const Vec3i dims = source_.layout().dims, size = piece.box.size();
    const size_t voxel = bytesPerVoxel(source_.layout().type);
    std::vector<std::byte> expected(static_cast<size_t>(piece.box.count()) * voxel);
    source_.readRegion(0, piece.box, expected);
    const std::lock_guard lock(mutex_);
    EXPECT_GE(piece.box.lo.z, ended_);
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(piece.box.lo[a] % side_, 0);
      EXPECT_TRUE(piece.box.hi[a] % side_ == 0 || piece.box.hi[a] == dims[a]);
    }
    size_t at = 0;
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y)
        for (int64_t x = 0; x < size.x; ++x, at += voxel) {
          const Vec3i p = piece.box.lo + Vec3i{x, y, z};
          ++times_[static_cast<size_t>((p.z * dims.y + p.y) * dims.x + p.x)];
          const std::byte* found =
              piece.voxels +
              (z * piece.plane_stride + y * piece.row_stride + x) * static_cast<int64_t>(voxel);
          if (std::memcmp(found, expected.data() + at, voxel) != 0) ++wrong;
        }
  }
  void layersBefore(int64_t end) override {
    EXPECT_EQ(end, std::min(ended_ + side_, source_.layout().dims.z));
    ended_ = end;
  }
  // The least and the most often that a voxel came.
  std::pair<int, int> times() const {
    const auto [least, most] = std::minmax_element(times_.begin(), times_.end());
    return {*least, *most};
  }
  int64_t ended() const { return ended_; }

  bool wants = true;
  bool looks = true;  // false: it reads nothing itself
  int64_t wrong = 0;

 private:
  VolumeSource& source_;
  const int64_t side_;
  std::mutex mutex_;
  std::vector<int> times_;
  int64_t ended_ = 0;
};

struct Built {
  SliceRanges ranges;
  BrickRanges bricks;
};

Built build(VolumeSource& source, const BlockLayout& layout, uint64_t most_bytes,
            VoxelTaker* taker) {
  WorkerPool pool(3);
  ProgressMeter progress;
  Built built;
  built.ranges =
      buildSliceRanges(source, 0, layout, {pool, progress, most_bytes}, built.bricks, taker);
  return built;
}

void expectSame(const Built& a, const Built& b) {
  EXPECT_EQ(a.ranges.background, b.ranges.background);
  EXPECT_EQ(a.ranges.blocks, b.ranges.blocks);
  EXPECT_EQ(a.ranges.totals, b.ranges.totals);
  EXPECT_EQ(a.ranges.planes, b.ranges.planes);
  EXPECT_EQ(a.ranges.device_range, b.ranges.device_range);
  EXPECT_EQ(a.ranges.far_range, b.ranges.far_range);
  EXPECT_EQ(a.ranges.counts, b.ranges.counts);
  EXPECT_EQ(a.bricks.cells, b.bricks.cells);
  EXPECT_EQ(a.bricks.ranges, b.bricks.ranges);
}

TEST(SharedPass, makesTheSameArraysAndHandsOutEachVoxelOnce) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32, VoxelType::kF64})
    for (const Vec3i dims : {Vec3i{70, 41, 33}, Vec3i{16, 16, 16}, Vec3i{9, 50, 17}}) {
      const auto source = makeWhiteNoise(dims, type, 11);
      const BlockLayout layout = blockLayout(dims, 16, 1);
      const Built alone = build(*source, layout, kMostIndexingBytes, nullptr);
      // With little memory rows are cut into several pieces.
      for (const uint64_t bytes : {kMostIndexingBytes, uint64_t{1}})
        for (const int64_t side : {8, 16, 64}) {
          SCOPED_TRACE(testing::Message() << name(type) << " " << dims.x << " side " << side);
          NotingTaker taker(*source, side);
          const Built shared = build(*source, layout, bytes, &taker);
          expectSame(shared, alone);
          EXPECT_EQ(taker.times(), std::pair(1, 1));
          EXPECT_EQ(taker.wrong, 0);
          EXPECT_EQ(taker.ended(), dims.z);
        }
    }
}

TEST(SharedPass, ofASparseVolumeReadsWhatIsStored) {
  BlobOptions options;
  options.dims = {80, 60, 50};
  const auto source = makeSparseBlobs(options);
  const BlockLayout layout = blockLayout(options.dims, 8, 0);
  const Built alone = build(*source, layout, kMostIndexingBytes, nullptr);
  NotingTaker taker(*source, 16);
  expectSame(build(*source, layout, kMostIndexingBytes, &taker), alone);
  EXPECT_LE(taker.times().second, 1);
  EXPECT_EQ(taker.wrong, 0);
}

TEST(SharedPass, forTheTakerAloneReadsTheLayersThatItWants) {
  const auto source = makeWhiteNoise({40, 30, 20}, VoxelType::kU16, 2);
  WorkerPool pool(2);
  ProgressMeter progress;
  for (const bool wants : {true, false}) {
    NotingTaker taker(*source, 8);
    taker.wants = wants;
    passVoxels(*source, 0, blockLayout({40, 30, 20}, 16, 0), {pool, progress, 1 << 20}, taker);
    EXPECT_EQ(taker.times(), wants ? std::pair(1, 1) : std::pair(0, 0));
    EXPECT_EQ(taker.wrong, 0);
    EXPECT_EQ(taker.ended(), 20);
  }
}

// Layers that nobody wants and background that is not stored are no reason to end halfway.
TEST(SharedPass, itsProgressReachesTheEnd) {
  BlobOptions options;
  options.dims = {80, 60, 50};
  const auto sparse = makeSparseBlobs(options),
             dense = makeWhiteNoise({40, 30, 20}, VoxelType::kU16, 2);
  WorkerPool pool(2);
  for (VolumeSource* source : {sparse.get(), dense.get()})
    for (const bool wants : {true, false}) {
      const VolumeLayout& voxels = source->layout();
      const BlockLayout layout = blockLayout(voxels.dims, 8, 0);
      const uint64_t all = static_cast<uint64_t>(volume(voxels.dims)) * bytesPerVoxel(voxels.type);
      uint64_t last = 0;
      const ProgressWatch watch = [&](uint64_t done, uint64_t total) {
        EXPECT_EQ(total, all);
        EXPECT_LE(done, total);
        last = std::max(last, done);
      };
      NotingTaker taker(*source, 16);
      taker.wants = wants;
      ProgressMeter alone(watch);
      passVoxels(*source, 0, layout, {pool, alone, 1 << 20}, taker);
      EXPECT_EQ(last, all);
      last = 0;
      ProgressMeter shared(watch);
      NotingTaker other(*source, 16);
      BrickRanges bricks;
      buildSliceRanges(*source, 0, layout, {pool, shared, 1 << 20}, bricks, &other);
      EXPECT_EQ(last, all);
    }
}

// Notes how many reads had begun when it was told of a box.
class TellingSource final : public ForwardingSource {
 public:
  using ForwardingSource::ForwardingSource;
  void expectRegion(int64_t time, const Box3& box) override {
    EXPECT_EQ(time, 0);
    told.push_back({box, reads});
  }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    read.push_back(box);
    ++reads;
    ForwardingSource::readRegion(time, box, out);
  }
  void readRegions(int64_t time, std::span<const RegionRead> regions) override {
    VolumeSource::readRegions(time, regions);
  }

  struct Told {
    Box3 box;
    size_t reads;
  };
  std::vector<Told> told;
  std::vector<Box3> read;
  size_t reads = 0;
};

// Every piece but the first two, in the order of the reads, two reads before its own.
void expectToldBeforehand(const TellingSource& source) {
  ASSERT_GT(source.read.size(), 8U);
  ASSERT_EQ(source.told.size(), source.read.size() - 2);
  for (size_t i = 0; i < source.told.size(); ++i) {
    EXPECT_EQ(source.told[i].box, source.read[i + 2]) << i;
    EXPECT_EQ(source.told[i].reads, i) << i;
  }
}

TEST(SharedPass, tellsTheSourceOfEachPieceBeforehandAcrossLayers) {
  // Tiles of 16 planes: three layers of three.
  TellingSource source(makeWhiteNoise({33, 47, 41}, VoxelType::kU8, 4));
  WorkerPool alone(1);
  ProgressMeter progress;
  BrickRanges bricks;
  NotingTaker taker(source, 16);
  taker.looks = false;
  buildSliceRanges(source, 0, blockLayout({33, 47, 41}, 16, 0), {alone, progress}, bricks, &taker);
  expectToldBeforehand(source);
}

TEST(SharedPass, tellsTheSourceOfRunsToo) {
  TellingSource source(makeWhiteNoise({33, 47, 41}, VoxelType::kU8, 4));
  WorkerPool alone(1);
  ProgressMeter progress;
  buildSliceRanges(source, 0, blockLayout({33, 47, 41}, 16, 0), {alone, progress});
  expectToldBeforehand(source);
}

}  // namespace
}  // namespace sluice
