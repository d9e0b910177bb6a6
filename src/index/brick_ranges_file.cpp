#include "src/index/brick_ranges_file.h"

#include <utility>

#include "src/base/files/byte_stream.h"

namespace sluice {

std::vector<std::byte> serialize(const BrickRanges& bricks) {
  ByteWriter out;
  out.value(bricks.cells);
  out.list(bricks.ranges);
  return std::move(out.bytes);
}

std::optional<BrickRanges> deserializeBricks(std::span<const std::byte> bytes, Vec3i dims,
                                             DeviceType type) {
  ByteReader in(bytes);
  Box3 cells;
  if (!in.value(cells) || !boxOf(dims - Vec3i{1, 1, 1}).contains(cells)) return std::nullopt;
  BrickRanges bricks = brickGrid(cells);
  if (!in.list(bricks.ranges) || !in.left().empty()) return std::nullopt;
  const auto count = static_cast<size_t>(volume(bricks.grid()));
  if (bricks.ranges.size() != count * 2 * bytesPerVoxel(type)) return std::nullopt;
  return bricks;
}

}  // namespace sluice
