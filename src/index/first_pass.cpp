#include "src/index/first_pass.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "src/volume/ranges/brick_ranges.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {
namespace {

// Blocks that may differ from a background, estimated by the volume of the boxes in which they lie:
// a box smaller than a block counts for its part of one.
double blocksAtMost(const BlockLayout& layout, const std::optional<Occupancy>& occupancy) {
  const auto all = static_cast<double>(layout.blockCount());
  if (!occupancy) return all;
  const auto cells = static_cast<double>(layout.cells());
  double blocks = 0;
  for (const Box3& box : occupancy->boxes) {
    const Vec3d size = toDouble(box.size()) / cells;
    blocks += size.x * size.y * size.z;
  }
  return std::min(all, blocks);
}

std::string wholeMebibytes(double bytes) {
  constexpr double kMebibyte = 1 << 20;
  return fmt::format("{:.0f}M", std::ceil(bytes / kMebibyte));
}

}  // namespace

FirstPass planFirstPass(VolumeSource& source, int64_t time, const BlockLayout& layout,
                        uint64_t memory_bytes, int threads,
                        const std::function<uint64_t(uint64_t array_bytes)>& enough_to_draw) {
  const VolumeLayout& voxels = source.layout();
  const auto device_bytes = static_cast<double>(bytesPerVoxel(deviceMap(voxels).type));
  constexpr double kAxes = 3, kEnds = 2;
  // Asked once, because an answer may take a listing of all chunks on a server.
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  const Vec3i bricks = brickGrid(brickCells(layout.dims, occupancy)).grid();
  // Bricks and arrays stay resident, so that they must fit even if nothing else is in memory.
  const double array_bytes =
      static_cast<double>(volume(bricks)) * kEnds * device_bytes +
      blocksAtMost(layout, occupancy) *
          (sizeof(int64_t) +
           kEnds * device_bytes * (1 + kAxes * static_cast<double>(layout.planes())));
  // One line names a budget that opens the volume, and one with which any picture of it is drawn.
  const auto budgets = [&](double least) {
    std::string text = "give --memory " + wholeMebibytes(least) + " or more to look at it";
    constexpr double kMost = 0x1p62;
    if (enough_to_draw != nullptr && array_bytes < kMost) {
      const auto enough = static_cast<double>(enough_to_draw(static_cast<uint64_t>(array_bytes)));
      text += fmt::format(", and {} to draw it", wholeMebibytes(std::max(least, enough)));
    }
    return text;
  };
  if (array_bytes > static_cast<double>(memory_bytes))
    failMemory(
        "{}: {} x {} x {} voxels in blocks of {} a side have {} of min-max arrays, --memory is {}; "
        "{}, or a larger --block",
        voxels.calledBy(), voxels.dims.x, voxels.dims.y, voxels.dims.z, layout.size,
        wholeMebibytes(array_bytes), formatBytes(memory_bytes), budgets(array_bytes));

  // A volume smaller than a block is read whole.
  const Vec3i block = min(voxels.dims, Vec3i{layout.size, layout.size, layout.size});
  const uint64_t block_bytes = static_cast<uint64_t>(volume(block)) *
                               (bytesPerVoxel(voxels.type) + static_cast<uint64_t>(device_bytes));
  const uint64_t thread_bytes = source.heldBytesAThread() + block_bytes;
  if (thread_bytes > memory_bytes)
    failMemory(
        "{}: reading it takes {} at a time (decoded chunks or rows, and a block), --memory is {}; "
        "{}",
        voxels.calledBy(), formatBytes(thread_bytes), formatBytes(memory_bytes),
        budgets(std::max(static_cast<double>(thread_bytes), array_bytes)));
  const uint64_t for_threads = memory_bytes - memory_bytes / 4;
  FirstPass pass;
  pass.threads = static_cast<int>(
      std::clamp<uint64_t>(for_threads / thread_bytes, 1, static_cast<uint64_t>(threads)));
  // More memory makes the pass no faster (kMostIndexingBytes).
  const uint64_t held = static_cast<uint64_t>(pass.threads) * source.heldBytesAThread();
  pass.voxel_bytes = std::min(for_threads - std::min(for_threads, held), kMostIndexingBytes);
  return pass;
}

}  // namespace sluice
