#include "src/volume/slice_ranges_file.h"

#include <cstring>
#include <type_traits>

#include "src/base/large_pages.h"

namespace sluice {
namespace {

// Appends and takes back plain values and vectors of them, with lengths in front.
class Writer {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* from = reinterpret_cast<const std::byte*>(&v);
    bytes.insert(bytes.end(), from, from + sizeof v);
  }
  template <class T>
  void list(const std::vector<T>& v) {
    value<uint64_t>(v.size());
    const auto raw = std::as_bytes(std::span(v));
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  }
  std::vector<std::byte> bytes;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <class T>
  bool value(T& v) {
    if (left_.size() < sizeof v) return false;
    std::memcpy(&v, left_.data(), sizeof v);
    left_ = left_.subspan(sizeof v);
    return true;
  }
  template <class T>
  bool list(std::vector<T>& v) {
    uint64_t count = 0;
    if (!value(count) || count > left_.size() / sizeof(T)) return false;
    reserveLarge(v, count);
    v.resize(count);
    if (count > 0) std::memcpy(v.data(), left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
    return true;
  }
  bool atEnd() const { return left_.empty(); }

 private:
  std::span<const std::byte> left_;
};

struct Header {
  int64_t dims[3];
  int64_t size, ghost, type;
  double scale, offset;
  friend bool operator==(const Header&, const Header&) = default;
};

Header headerOf(const BlockLayout& layout, const ValueMap& map) {
  return {{layout.dims.x, layout.dims.y, layout.dims.z},
          layout.size,
          layout.ghost,
          static_cast<int64_t>(map.type),
          map.scale,
          map.offset};
}

// Ids that exist, each once: what every loop over the blocks relies on.
bool isAscending(const std::vector<int64_t>& blocks, int64_t count) {
  int64_t least = 0;
  for (const int64_t block : blocks) {
    if (block < least) return false;
    least = block + 1;
  }
  return least <= count;
}

}  // namespace

std::vector<std::byte> serialize(const SliceRanges& ranges) {
  Writer out;
  out.value(headerOf(ranges.layout, ranges.map));
  out.value(ranges.background);
  out.value(ranges.device_range);
  out.value(ranges.histogram.range);
  out.list(ranges.histogram.counts);
  out.list(ranges.blocks);
  out.list(ranges.totals);
  out.list(ranges.planes);
  return std::move(out.bytes);
}

std::optional<SliceRanges> deserialize(std::span<const std::byte> bytes, const BlockLayout& layout,
                                       const ValueMap& map) {
  Reader in(bytes);
  SliceRanges ranges;
  ranges.layout = layout;
  ranges.map = map;
  Header header{};
  const bool whole = in.value(header) && header == headerOf(layout, map) &&
                     in.value(ranges.background) && in.value(ranges.device_range) &&
                     in.value(ranges.histogram.range) && in.list(ranges.histogram.counts) &&
                     in.list(ranges.blocks) && in.list(ranges.totals) && in.list(ranges.planes) &&
                     in.atEnd();
  if (!whole) return std::nullopt;
  const size_t element = 2 * bytesPerVoxel(map.type);
  const size_t held = ranges.blocks.size();
  if (ranges.totals.size() != held * element ||
      ranges.planes.size() != held * element * 3 * static_cast<size_t>(layout.planes()) ||
      ranges.histogram.counts.empty() || !isAscending(ranges.blocks, layout.blockCount()))
    return std::nullopt;
  return ranges;
}

}  // namespace sluice
