#include "tests/volume/slice_ranges_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace sluice {

SliceRanges buildRanges(VolumeSource& source, int64_t size, int ghost, int threads, int64_t time) {
  WorkerPool pool(threads);
  ProgressMeter quiet;
  return buildSliceRanges(source, time, blockLayout(source.layout().dims, size, ghost),
                          {pool, quiet, kMostIndexingBytes});
}

double deviceValue(VoxelType type, double stored) {
  switch (type) {
    case VoxelType::kU8:
    case VoxelType::kU16:
      return stored;
    case VoxelType::kI8:
      return stored + 128;
    case VoxelType::kI16:
      return stored + 32768;
    default:
      return static_cast<double>(static_cast<float>(stored));
  }
}

double voxelAt(const MemorySource& source, int64_t time, Vec3i p) {
  const VolumeLayout& layout = source.layout();
  return visitVoxelType(layout.type, [&](auto tag) {
    const int64_t at = ((time * layout.dims.z + p.z) * layout.dims.y + p.y) * layout.dims.x + p.x;
    std::memcpy(&tag, source.bytes().data() + at * static_cast<int64_t>(sizeof tag), sizeof tag);
    return deviceValue(layout.type, static_cast<double>(tag));
  });
}

void VoxelRange::take(double v) {
  lo = std::min(lo, v);
  hi = std::max(hi, v);
}

VoxelRange rangeOf(const Box3& box, const VoxelAt& voxel) {
  VoxelRange range;
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y)
      for (int64_t x = box.lo.x; x < box.hi.x; ++x) range.take(voxel(Vec3i{x, y, z}));
  return range;
}

void expectRangesOf(const SliceRanges& ranges, const VoxelAt& voxel) {
  const BlockLayout& layout = ranges.layout;
  size_t held = 0;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const Box3 cells = layout.ownedCells(layout.indexOf(block));
    const Box3 own{cells.lo, cells.hi + Vec3i{1, 1, 1}};
    const VoxelRange all = rangeOf(own, voxel);
    if (held == ranges.blocks.size() || ranges.blocks[held] != block) {
      ASSERT_EQ(all.lo, ranges.background) << "block " << block;
      ASSERT_EQ(all.hi, ranges.background) << "block " << block;
      continue;
    }
    visitDeviceType(ranges.map.type, [&](auto tag) {
      using T = decltype(tag);
      const PlaneRange<T> total = ranges.totalsAs<T>()[held];
      ASSERT_EQ(static_cast<double>(total.lo), all.lo) << "block " << block;
      ASSERT_EQ(static_cast<double>(total.hi), all.hi) << "block " << block;
      for (int axis = 0; axis < 3; ++axis) {
        const auto planes = ranges.planesAs<T>(held, axis);
        ASSERT_EQ(static_cast<int64_t>(planes.size()), layout.planes());
        for (int64_t plane = 0; plane < layout.planes(); ++plane) {
          Box3 slice = own;
          slice.lo[axis] = own.lo[axis] + plane;
          slice.hi[axis] = slice.lo[axis] + 1;
          const PlaneRange<T> found = planes[static_cast<size_t>(plane)];
          if (slice.lo[axis] >= own.hi[axis]) {
            ASSERT_GT(found.lo, found.hi) << "padding";
            continue;
          }
          const VoxelRange expected = rangeOf(slice, voxel);
          ASSERT_EQ(static_cast<double>(found.lo), expected.lo)
              << "block " << block << " axis " << axis << " plane " << plane;
          ASSERT_EQ(static_cast<double>(found.hi), expected.hi)
              << "block " << block << " axis " << axis << " plane " << plane;
        }
      }
    });
    ++held;
  }
  EXPECT_EQ(held, ranges.blocks.size());
}

}  // namespace sluice
