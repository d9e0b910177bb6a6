#include "io/headers/raw/raw_source.h"

#include <gmock/gmock.h>

#include <cstring>
#include <random>
#include <thread>

#include "tests/io/headers/volume_files.h"

namespace sluice::raw_source_test {
namespace {

constexpr VoxelType kType = VoxelType::kU16;
constexpr Vec3i kDims{13, 11, 12};

// Bytes in memory that count the reads: the second observer.
class MemoryStore : public ByteStore {
 public:
  explicit MemoryStore(std::string bytes) : bytes_(std::move(bytes)) {}
  void read(uint64_t offset, std::span<const iovec> parts) override {
    ++reads;
    for (const iovec& part : parts) {
      ASSERT_LE(offset + part.iov_len, bytes_.size());
      std::memcpy(part.iov_base, bytes_.data() + offset, part.iov_len);
      offset += part.iov_len;
      read_bytes += part.iov_len;
    }
  }
  void expectRead(uint64_t offset, uint64_t bytes) override {
    EXPECT_EQ(reads, 0) << "said too late";
    expected.push_back({offset, bytes});
  }
  uint64_t storedBytesRead() const override { return read_bytes; }
  std::vector<std::string> paths() const override { return {}; }

  std::vector<std::pair<uint64_t, uint64_t>> expected;  // offset, bytes
  int reads = 0;
  uint64_t read_bytes = 0;

 private:
  const std::string bytes_;
};

VolumeLayout layoutOf(Vec3i dims, VoxelType type, int64_t time_steps = 1) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.type = type;
  layout.time_steps = time_steps;
  return layout;
}

void expectBox(VolumeSource& source, int64_t time, const Box3& box) {
  const std::vector<std::byte> bytes = readBox(source, time, box);
  size_t at = 0;
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y)
      for (int64_t x = box.lo.x; x < box.hi.x; ++x) {
        uint16_t voxel = 0;
        std::memcpy(&voxel, bytes.data() + at, sizeof(voxel));
        at += sizeof(voxel);
        ASSERT_EQ(voxel, knownVoxel(kType, {x, y, z}, time)) << x << " " << y << " " << z;
      }
}

Box3 randomBox(std::mt19937& random, Vec3i dims) {
  Box3 box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = std::uniform_int_distribution<int64_t>(0, dims[axis] - 1)(random);
    box.hi[axis] = std::uniform_int_distribution<int64_t>(box.lo[axis] + 1, dims[axis])(random);
  }
  return box;
}

TEST(RawSourceTest, readsAnyBoxOfAnyTimeStep) {
  const auto store = std::make_shared<MemoryStore>("skip" + knownVoxels(kType, kDims, 3));
  RawSource source(layoutOf(kDims, kType, 3), std::endian::native, {{store, 4}}, nullptr, "");
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) expectBox(source, i % 3, randomBox(random, kDims));
}

TEST(RawSourceTest, readsBoxesAcrossSegmentsThatCutRows) {
  // 4 segments of 3 planes each, then 22 of half a dozen rows: each with another offset.
  const std::string voxels = knownVoxels(kType, kDims, 2);
  for (const size_t count : {8U, 44U, 24U}) {
    ASSERT_EQ(voxels.size() % count, 0U);
    std::vector<RawSegment> segments;
    for (size_t i = 0; i < count; ++i) {
      const std::string front(i, '#');
      const size_t size = voxels.size() / count;
      segments.push_back({std::make_shared<MemoryStore>(front + voxels.substr(i * size, size)), i});
    }
    RawSource source(layoutOf(kDims, kType, 2), std::endian::native, segments, nullptr, "");
    std::mt19937 random(2);
    for (int i = 0; i < 200; ++i) expectBox(source, i % 2, randomBox(random, kDims));
  }
}

TEST(RawSourceTest, turnsTheOtherByteOrderAround) {
  const std::endian other =
      std::endian::native == std::endian::little ? std::endian::big : std::endian::little;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32, VoxelType::kF64}) {
    const std::string voxels = knownVoxels(type, kDims);
    const auto store = std::make_shared<MemoryStore>(swapped(voxels, type));
    RawSource source(layoutOf(kDims, type), other, {{store, 0}}, nullptr, "");
    EXPECT_TRUE(readAll(source) == voxels) << name(type);
  }
}

TEST(RawSourceTest, wholePlanesAreOneRead) {
  const auto store = std::make_shared<MemoryStore>(knownVoxels(kType, kDims));
  RawSource source(layoutOf(kDims, kType), std::endian::native, {{store, 0}}, nullptr, "");
  expectBox(source, 0, {{0, 0, 2}, {13, 11, 9}});
  EXPECT_EQ(store->reads, 1);
  EXPECT_EQ(store->read_bytes, 13U * 11 * 7 * 2);
}

TEST(RawSourceTest, bridgesSmallGapsAndCountsThem) {
  const auto store = std::make_shared<MemoryStore>(knownVoxels(kType, kDims));
  RawSource source(layoutOf(kDims, kType), std::endian::native, {{store, 0}}, nullptr, "");
  expectBox(source, 0, {{1, 1, 1}, {3, 4, 3}});
  EXPECT_EQ(store->reads, 1);
  // From (1,1,1) to (2,3,2): one plane, two rows and two voxels.
  EXPECT_EQ(store->read_bytes, (13U * 11 + 13 * 2 + 2) * 2);
  EXPECT_EQ(source.storedBytesRead(), store->read_bytes);
}

TEST(RawSourceTest, doesNotReadLargeGaps) {
  const Vec3i dims{5000, 3, 2};
  const auto store = std::make_shared<MemoryStore>(knownVoxels(VoxelType::kU8, dims));
  RawSource source(layoutOf(dims, VoxelType::kU8), std::endian::native, {{store, 0}}, nullptr, "");
  readBox(source, 0, {{10, 0, 0}, {20, 3, 2}});
  EXPECT_EQ(store->reads, 6);
  EXPECT_EQ(store->read_bytes, 60U);
}

TEST(RawSourceTest, gapsBesideLargePiecesAddAtMostAQuarter) {
  const Vec3i dims{3000, 4, 1};
  const auto store = std::make_shared<MemoryStore>(knownVoxels(VoxelType::kU8, dims));
  RawSource source(layoutOf(dims, VoxelType::kU8), std::endian::native, {{store, 0}}, nullptr, "");
  readBox(source, 0, {{0, 0, 0}, {2400, 4, 1}});  // gaps of 600
  EXPECT_EQ(store->reads, 1);
  EXPECT_EQ(store->read_bytes, 3U * 3000 + 2400);
  store->reads = 0, store->read_bytes = 0;
  readBox(source, 0, {{0, 0, 0}, {2300, 4, 1}});  // gaps of 700
  EXPECT_EQ(store->reads, 4);
  EXPECT_EQ(store->read_bytes, 4U * 2300);
}

TEST(RawSourceTest, regionsOfTheSameRowsAreReadOnce) {
  // Blocks of 5 voxels that share a plane, one that is missing between, in any order.
  const Vec3i dims{23, 6, 5};
  const std::string voxels = knownVoxels(kType, dims);
  for (const size_t segments : {1U, 5U, 10U}) {
    std::vector<std::shared_ptr<MemoryStore>> stores;
    std::vector<RawSegment> parts;
    for (size_t i = 0; i < segments; ++i) {
      const size_t size = voxels.size() / segments;
      stores.push_back(std::make_shared<MemoryStore>(voxels.substr(i * size, size)));
      parts.push_back({stores.back(), 0});
    }
    RawSource source(layoutOf(dims, kType), std::endian::native, parts, nullptr, "");
    std::vector<Box3> boxes;
    for (const int64_t x : {12, 0, 4, 18}) boxes.push_back({{x, 1, 1}, {x + 5, 5, 4}});
    std::vector<std::vector<std::byte>> found(boxes.size());
    std::vector<RegionRead> regions;
    for (size_t i = 0; i < boxes.size(); ++i) {
      found[i].resize(static_cast<size_t>(boxes[i].count()) * 2);
      regions.push_back({boxes[i], found[i]});
    }
    source.readRegions(0, regions);
    const uint64_t read_bytes = source.storedBytesRead();
    for (size_t i = 0; i < boxes.size(); ++i)
      EXPECT_TRUE(found[i] == readBox(source, 0, boxes[i])) << segments << " region " << i;
    if (segments == 1) {
      EXPECT_EQ(read_bytes, (2U * 6 * 23 + 3 * 23 + 23) * 2);  // from (0,1,1) to (22,4,3)
    }
  }
}

TEST(RawSourceTest, manyRowsTakeSeveralReadsOfBoundedSize) {
  const Vec3i dims{3, 100'000, 2};
  const auto store = std::make_shared<MemoryStore>(knownVoxels(kType, dims));
  RawSource source(layoutOf(dims, kType), std::endian::native, {{store, 0}}, nullptr, "");
  expectBox(source, 0, {{1, 0, 0}, {2, 100'000, 2}});
  EXPECT_EQ(store->reads, 5);  // 1.2 MB with the gaps, in reads of at most 256 KiB
}

// Rows of some neighbouring blocks: all of the file's pages there are wanted.
TEST(RawSourceTest, theDiskIsToldOfPiecesOfPlanesBeforeTheFirstIsRead) {
  const Vec3i dims{5000, 20, 7};
  const auto store = std::make_shared<MemoryStore>(knownVoxels(VoxelType::kU8, dims));
  RawSource source(layoutOf(dims, VoxelType::kU8), std::endian::native, {{store, 100}}, nullptr,
                   "");
  readBox(source, 0, {{905, 3, 2}, {5000, 13, 4}});
  const std::vector<std::pair<uint64_t, uint64_t>> rows{{100 + 43 * 5000, 50'000},
                                                        {100 + 63 * 5000, 50'000}};
  EXPECT_EQ(store->expected, rows);
}

TEST(RawSourceTest, theDiskIsNotToldOfPagesThatAreNotReadOrOfFew) {
  const Vec3i dims{5000, 20, 7};
  const auto store = std::make_shared<MemoryStore>(knownVoxels(VoxelType::kU8, dims));
  RawSource source(layoutOf(dims, VoxelType::kU8), std::endian::native, {{store, 0}}, nullptr, "");
  readBox(source, 0, {{0, 3, 2}, {904, 13, 4}});   // gaps of a page
  readBox(source, 0, {{0, 3, 2}, {5000, 8, 4}});   // 25 KB of a plane
  readBox(source, 0, {{0, 0, 2}, {5000, 20, 4}});  // a single piece
  EXPECT_TRUE(store->expected.empty());
}

TEST(RawSourceTest, theDiskIsToldOfABoxThatIsReadLater) {
  const Vec3i dims{5000, 20, 7};
  const auto front = std::make_shared<MemoryStore>(""), back = std::make_shared<MemoryStore>("");
  // Two time steps, in a file each.
  RawSource source(layoutOf(dims, VoxelType::kU8, 2), std::endian::native,
                   {{front, 100}, {back, 200}}, nullptr, "");
  source.expectRegion(1, {{905, 3, 2}, {5000, 13, 4}});
  const std::vector<std::pair<uint64_t, uint64_t>> rows{{200 + 43 * 5000, 50'000},
                                                        {200 + 63 * 5000, 50'000}};
  EXPECT_EQ(back->expected, rows);
  source.expectRegion(0, {{0, 0, 2}, {5000, 20, 3}});  // a single piece
  EXPECT_EQ(front->expected, (std::vector<std::pair<uint64_t, uint64_t>>{{200'100, 100'000}}));
  source.expectRegion(0, {{0, 3, 2}, {904, 13, 4}});  // gaps of a page
  EXPECT_EQ(front->expected.size(), 1U);
}

TEST(RawSourceTest, countsTheHeadersBytesToo) {
  const auto header = std::make_shared<MemoryStore>("");
  header->read_bytes = 7;
  const auto store = std::make_shared<MemoryStore>(knownVoxels(kType, kDims));
  RawSource source(layoutOf(kDims, kType), std::endian::native, {{store, 0}}, header, "who");
  EXPECT_EQ(source.storedBytesRead(), 7U);
  readBox(source, 0, {{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(source.storedBytesRead(), 9U);
  EXPECT_EQ(source.identity(), "who");
}

}  // namespace
}  // namespace sluice::raw_source_test
