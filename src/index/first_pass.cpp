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

double arrayBytes(VolumeSource& source, int64_t time, const BlockLayout& layout) {
  const auto device_bytes = static_cast<double>(bytesPerVoxel(deviceMap(source.layout()).type));
  constexpr double kAxes = 3, kEnds = 2;
  // Asked once, because an answer may take a listing of all chunks on a server.
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  const Vec3i bricks = brickGrid(brickCells(layout.dims, occupancy)).grid();
  return static_cast<double>(volume(bricks)) * kEnds * device_bytes +
         blocksAtMost(layout, occupancy) *
             (sizeof(int64_t) +
              kEnds * device_bytes * (1 + kAxes * static_cast<double>(layout.planes())));
}

// The bytes that a thread has in memory while it reads.
uint64_t threadBytes(const VolumeSource& source, const BlockLayout& layout) {
  const VolumeLayout& voxels = source.layout();
  // A volume smaller than a block is read whole.
  const Vec3i block = min(voxels.dims, Vec3i{layout.size, layout.size, layout.size});
  return source.heldBytesAThread() +
         static_cast<uint64_t>(volume(block)) *
             (bytesPerVoxel(voxels.type) + bytesPerVoxel(deviceMap(voxels).type));
}

}  // namespace

PassNeeds firstPassNeeds(VolumeSource& source, int64_t time, const BlockLayout& layout) {
  const double array_bytes = arrayBytes(source, time, layout);
  // Bricks and arrays stay resident, so that they must fit even if nothing else is in memory.
  return {array_bytes, std::max(array_bytes, static_cast<double>(threadBytes(source, layout)))};
}

FirstPass planFirstPass(VolumeSource& source, int64_t time, const BlockLayout& layout,
                        uint64_t memory_bytes, int threads,
                        const std::function<PassBudgets(const PassNeeds&)>& budgets) {
  const VolumeLayout& voxels = source.layout();
  const PassNeeds needs = firstPassNeeds(source, time, layout);
  // One line names a budget that opens the volume, and one with which any picture of it is drawn.
  const auto advice = [&] {
    const PassBudgets named = budgets ? budgets(needs) : PassBudgets{needs.least_bytes, 0};
    std::string text =
        "give --memory " + wholeMebibytes(named.look_bytes) + " or more to look at it";
    if (named.draw_bytes > 0)
      text += fmt::format(", and {} to draw it",
                          wholeMebibytes(std::max(named.look_bytes, named.draw_bytes)));
    return text;
  };
  if (needs.array_bytes > static_cast<double>(memory_bytes))
    failMemory(
        "{}: {} x {} x {} voxels in blocks of {} a side have {} of min-max arrays, --memory is {}; "
        "{}, or a larger --block",
        voxels.calledBy(), voxels.dims.x, voxels.dims.y, voxels.dims.z, layout.size,
        wholeMebibytes(needs.array_bytes), formatBytes(memory_bytes), advice());
  const uint64_t thread_bytes = threadBytes(source, layout);
  if (thread_bytes > memory_bytes)
    failMemory(
        "{}: reading it takes {} at a time (decoded chunks or rows, and a block), --memory is {}; "
        "{}",
        voxels.calledBy(), formatBytes(thread_bytes), formatBytes(memory_bytes), advice());
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
