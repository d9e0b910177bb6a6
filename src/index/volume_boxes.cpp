#include "src/index/volume_boxes.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "src/base/memory/aligned_array.h"
#include "src/base/threads/mutex.h"
#include "src/classify/boxes/box_visibility.h"
#include "src/index/stale_check.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {
namespace {

// Read at a time by a thread, so that progress is seen.
constexpr uint64_t kMostBytesPerRead = uint64_t{16} << 20;
constexpr int64_t kPerfectSide = 8;

// Neighbouring blocks along x.
struct BlockRun {
  size_t first = 0, count = 1;  // in the list of blocks
};

std::vector<BlockRun> runsOf(const BlockLayout& layout, std::span<const int64_t> blocks,
                             uint64_t most) {
  std::vector<BlockRun> runs;
  for (size_t i = 0; i < blocks.size(); ++i) {
    // A run stays in its row: ids go on in the next row, but the voxels do not.
    const bool joins = i > 0 && blocks[i] == blocks[i - 1] + 1 && blocks[i] % layout.grid.x != 0 &&
                       runs.back().count < most;
    if (joins)
      ++runs.back().count;
    else
      runs.push_back({i, 1});
  }
  return runs;
}

Vec3d voxelSize(const VolumeLayout& layout) {
  // The shortest side of a voxel is 1, as gradients are measured in it.
  return layout.spacing / std::min({layout.spacing.x, layout.spacing.y, layout.spacing.z});
}

// Voxels read for a whole block; see voxelsAround.
uint64_t cornerVoxels(const BlockLayout& layout) {
  // The planes of the cells' corners, and one more on each side for central differences.
  const int64_t side = layout.cells() + 3;
  return static_cast<uint64_t>(volume(Vec3i{side, side, side}));
}

// The voxels at the corners of `cells` and one layer more, as far as they exist.
Box3 voxelsAround(const Box3& cells, Vec3i dims) {
  return intersect({cells.lo - Vec3i{1, 1, 1}, cells.hi + Vec3i{2, 2, 2}}, boxOf(dims));
}

struct DeviceVoxels {
  Box3 box;
  DeviceType type;
  AlignedArray<std::byte> bytes;
};

DeviceVoxels readDevice(VolumeSource& source, int64_t time, const Box3& box,
                        const ReadVoxels& read) {
  DeviceVoxels voxels{box, deviceMap(source.layout()).type, {}};
  const auto bytes = static_cast<size_t>(box.count()) * bytesPerVoxel(voxels.type);
  voxels.bytes = alignedForOverwrite<std::byte>(bytes);
  const RegionRead region{box, {voxels.bytes.get(), bytes}};
  if (read)
    read(time, region);
  else
    DeviceReader(source, kMostBytesPerRead).read(time, region);
  return voxels;
}

// Adds the cost of one block to the cost of all.
class Counter {
 public:
  Counter(const BoxVisibility& visibility, const Box3& crop)
      : visibility_(visibility), crop_(crop) {}

  PartitionCost of(const BrickGrid& grid, const BoxTree& tree) const {
    PartitionCost cost;
    cost.blocks = 1;
    cost.grown = tree.grown;
    cost.boxes = static_cast<int64_t>(tree.boxes.size());
    cost.textures = static_cast<int64_t>(tree.textures.size());
    for (const GrownBox& box : tree.boxes) {
      ++cost.types[static_cast<size_t>(box.type)];
      const int64_t cells = shownCells(grid, box.local(), box.range);
      cost.visible_cells += cells;
      cost.visible_boxes += cells > 0 ? 1 : 0;
    }
    addPerfect(grid, cost);
    return cost;
  }

 private:
  int64_t shownCells(const BrickGrid& grid, const Box3& local, const CellRange& range) const {
    if (!visibility_.shows(range)) return 0;
    return intersect(translate(local, grid.cells.lo), crop_).count();
  }

  void addPerfect(const BrickGrid& grid, PartitionCost& cost) const {
    // Perfect bricks have 8 cells, which must be whole bricks of ours.
    if (kPerfectSide % grid.side != 0) return;
    const int64_t side = kPerfectSide / grid.side;
    for (int64_t z = 0; z < grid.size.z; z += side)
      for (int64_t y = 0; y < grid.size.y; y += side)
        for (int64_t x = 0; x < grid.size.x; x += side) {
          const Vec3i lo{x, y, z};
          const Box3 bricks{lo, min(lo + Vec3i{side, side, side}, grid.size)};
          const int64_t cells = shownCells(grid, grid.cellsOf(bricks), rangeOf(grid, bricks));
          cost.perfect_cells += cells;
          cost.perfect_bricks += cells > 0 ? 1 : 0;
        }
  }

  const BoxVisibility& visibility_;
  const Box3& crop_;
};

void add(PartitionCost& sum, const PartitionCost& by) {
  sum.blocks += by.blocks;
  sum.grown += by.grown;
  sum.boxes += by.boxes;
  sum.textures += by.textures;
  for (size_t i = 0; i < sum.types.size(); ++i) sum.types[i] += by.types[i];
  sum.visible_boxes += by.visible_boxes;
  sum.visible_cells += by.visible_cells;
  sum.perfect_bricks += by.perfect_bricks;
  sum.perfect_cells += by.perfect_cells;
}

// Blocks, bricks and cells of a box of blocks that the crop reaches into; all three are products
// over the axes.
struct Extent {
  int64_t blocks = 1, bricks = 1, cells = 1;
};
Extent extentOf(const BlockLayout& layout, const Box3& blocks, const Box3& crop) {
  Extent extent;
  for (int a = 0; a < 3; ++a) {
    Extent sum{0, 0, 0};
    for (int64_t i = blocks.lo[a]; i < blocks.hi[a]; ++i) {
      const int64_t first = i * layout.cells();
      const int64_t end =
          std::min({first + layout.cells(), layout.dims[a] - 1, crop.hi[a]}) - first;
      // A block's last bricks may be cut by the crop: bricks count from the block's first cell.
      const int64_t begin = std::max(crop.lo[a] - first, int64_t{0});
      if (begin >= end) continue;
      ++sum.blocks;
      sum.bricks += ceilDiv(end, kPerfectSide) - begin / kPerfectSide;
      sum.cells += end - begin;
    }
    extent = {extent.blocks * sum.blocks, extent.bricks * sum.bricks, extent.cells * sum.cells};
  }
  return extent;
}

// Blocks that are not held are one uniform box each; they show all of themselves or nothing.
void addBackground(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                   PartitionCost& cost) {
  const BlockLayout& layout = ranges.layout;
  const int64_t count = layout.blockCount() - static_cast<int64_t>(ranges.blocks.size());
  cost.grown += count;
  cost.boxes += count;
  cost.types[static_cast<size_t>(BoxType::kUniform)] += count;
  if (count == 0 || !table.shown().anyIn(ranges.background, ranges.background)) return;
  // All blocks as if they were background, less those that are held: sums over the axes need no
  // list of the others.
  const Extent all = extentOf(layout, boxOf(layout.grid), crop);
  cost.visible_boxes += all.blocks;
  cost.visible_cells += all.cells;
  cost.perfect_bricks += all.bricks;
  cost.perfect_cells += all.cells;
  for (const int64_t block : ranges.blocks) {
    const Vec3i index = layout.indexOf(block);
    const Extent held = extentOf(layout, {index, index + Vec3i{1, 1, 1}}, crop);
    cost.visible_boxes -= held.blocks;
    cost.visible_cells -= held.cells;
    cost.perfect_bricks -= held.bricks;
    cost.perfect_cells -= held.cells;
  }
}

}  // namespace

uint64_t growingBytes(const VolumeLayout& volume, const BlockLayout& layout) {
  return cornerVoxels(layout) *
         (bytesPerVoxel(volume.type) + bytesPerVoxel(deviceMap(volume).type));
}

void expectSameValues(const VolumeSource& source, int64_t time, const SliceRanges& ranges,
                      int64_t block, const BrickGrid& grid) {
  const CellRange found = rangeOf(grid, boxOf(grid.size));
  expectSameValues({.time = time, .block = block}, {found.lo, found.hi},
                   expectedValues(ranges, block),
                   {source.layout().calledBy(), ranges.map, ranges.index_file});
}

void forEachBlockBricks(VolumeSource& source, int64_t time, const BlockLayout& layout,
                        std::span<const int64_t> blocks, const VolumePass& pass,
                        const TakeBricks& take, const ReadVoxels& read) {
  const VolumeLayout& voxels = source.layout();
  const uint64_t bytes_per_read =
      std::min(kMostBytesPerRead, pass.memory_bytes / static_cast<uint64_t>(pass.pool.threads()));
  const uint64_t most = std::max<uint64_t>(1, bytes_per_read / growingBytes(voxels, layout));
  const std::vector<BlockRun> runs = runsOf(layout, blocks, most);
  // Blocks of a run share planes, so that a little less is read.
  const uint64_t block_bytes = cornerVoxels(layout) * bytesPerVoxel(voxels.type);
  pass.progress.expect(blocks.size() * block_bytes);
  const Vec3d voxel_size = voxelSize(voxels);
  pass.pool.parallelFor(static_cast<int64_t>(runs.size()), [&](int64_t i) {
    pass.stop.throwIfStopped();
    const BlockRun& run = runs[static_cast<size_t>(i)];
    const std::span<const int64_t> of_run = blocks.subspan(run.first, run.count);
    // One read for the whole run, because rows of the volume lie together in the file.
    const Box3 cells = unite(layout.ownedCells(layout.indexOf(of_run.front())),
                             layout.ownedCells(layout.indexOf(of_run.back())));
    const DeviceVoxels held = readDevice(source, time, voxelsAround(cells, layout.dims), read);
    const VoxelSpan span{held.box, held.type, held.bytes.get()};
    for (const int64_t block : of_run)
      take(block, brickGrid(span, layout.ownedCells(layout.indexOf(block)), kGrowingBrickSide,
                            voxel_size));
    pass.progress.add(run.count * block_bytes);
  });
}

PartitionCost partitionCost(VolumeSource& source, int64_t time, const SliceRanges& ranges,
                            const OpacityTable& table, const Box3& crop, const VolumePass& pass,
                            const TakeTree& take) {
  const GrowingParameters parameters = growingParameters(ranges.map.type, ranges.device_range);
  const BoxVisibility visibility(table, source.layout());
  const Counter counter(visibility, crop);
  PartitionCost sum;
  Mutex mutex;  // guards `sum`
  const auto addBlock = [&](int64_t block, const BrickGrid& grid) {
    expectSameValues(source, time, ranges, block, grid);
    const BoxTree tree = growBoxTree(grid, parameters);
    if (take) take(block, tree);
    const PartitionCost cost = counter.of(grid, tree);
    const MutexLock lock(mutex);
    add(sum, cost);
  };
  forEachBlockBricks(source, time, ranges.layout, ranges.blocks, pass, addBlock);
  addBackground(ranges, table, crop, sum);
  return sum;
}

}  // namespace sluice
