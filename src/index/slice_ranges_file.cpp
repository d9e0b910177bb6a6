#include "src/index/slice_ranges_file.h"

#include <cmath>

#include "src/base/files/byte_stream.h"

namespace sluice {
namespace {

struct RangesHeader {
  int64_t dims[3];
  int64_t size, ghost, type;
  double scale, offset;
  friend bool operator==(const RangesHeader&, const RangesHeader&) = default;
};

RangesHeader headerOf(const BlockLayout& layout, const ValueMap& map) {
  return {{layout.dims.x, layout.dims.y, layout.dims.z},
          layout.size,
          layout.ghost,
          static_cast<int64_t>(map.type),
          map.scale,
          map.offset};
}

// Whether ids exist, each once, as every loop over the blocks assumes.
bool isAscending(const std::vector<int64_t>& blocks, int64_t count) {
  int64_t least = 0;
  for (const int64_t block : blocks) {
    if (block < least) return false;
    least = block + 1;
  }
  return least <= count;
}

// Numbers in the order that their users rely on.
bool areCounts(const std::vector<ValueCount>& entries) {
  for (size_t i = 0; i < entries.size(); ++i) {
    const ValueCount& entry = entries[i];
    if (!std::isfinite(entry.lo) || !std::isfinite(entry.hi) || entry.hi < entry.lo) return false;
    if (entry.count == 0 || (i > 0 && entry.lo < entries[i - 1].lo)) return false;
  }
  return entries.size() <= kMostValueCounts + 1;
}

}  // namespace

std::vector<std::byte> serialize(const SliceRanges& ranges) {
  ByteWriter out;
  out.value(headerOf(ranges.layout, ranges.map));
  out.value(ranges.background);
  out.value(ranges.device_range);
  out.value(ranges.far_range);
  out.value(ranges.counts.changes);
  out.value(ranges.counts.jumps);
  out.list(ranges.counts.entries);
  out.list(ranges.blocks);
  out.list(ranges.totals);
  out.list(ranges.planes);
  return std::move(out.bytes);
}

std::optional<SliceRanges> deserialize(std::span<const std::byte> bytes, const BlockLayout& layout,
                                       const ValueMap& map) {
  ByteReader in(bytes);
  SliceRanges ranges;
  ranges.layout = layout;
  ranges.map = map;
  RangesHeader header{};
  // A header that differs belongs to another volume or layout under the same key.
  const bool whole = in.value(header) && header == headerOf(layout, map) &&
                     in.value(ranges.background) && in.value(ranges.device_range) &&
                     in.value(ranges.far_range) && in.value(ranges.counts.changes) &&
                     in.value(ranges.counts.jumps) && in.list(ranges.counts.entries) &&
                     in.list(ranges.blocks) && in.list(ranges.totals) && in.list(ranges.planes) &&
                     in.left().empty();
  if (!whole) return std::nullopt;
  // Sizes are compared with the number of blocks, so that no index reaches beyond the arrays.
  // An element is the least and the greatest voxel.
  const size_t element = 2 * bytesPerVoxel(map.type);
  const size_t held = ranges.blocks.size();
  if (ranges.totals.size() != held * element ||
      ranges.planes.size() != held * element * 3 * static_cast<size_t>(layout.planes()) ||
      !areCounts(ranges.counts.entries) || !isAscending(ranges.blocks, layout.blockCount()))
    return std::nullopt;
  return ranges;
}

}  // namespace sluice
