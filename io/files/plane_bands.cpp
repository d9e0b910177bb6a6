#include "io/files/plane_bands.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

namespace sluice {

PlaneBands::PlaneBands(const Shape& shape, Decode decode)
    : shape_(shape), decode_(std::move(decode)) {
  holdAtMost(0);
}

int64_t PlaneBands::usualBandRows(int64_t height, int64_t row_bytes, int64_t unit_rows) {
  constexpr int64_t kBandBytes = int64_t{512} << 10, kMaxUnitBytes = int64_t{8} << 20;
  const int64_t wanted = std::clamp<int64_t>(unit_rows, 1, height);
  // Bands are whole strips or tiles, which are decoded as a whole, unless one is very large.
  const int64_t unit = wanted * row_bytes <= kMaxUnitBytes ? wanted : 1;
  return std::min(std::max<int64_t>(kBandBytes / row_bytes / unit, 1) * unit, height);
}

void PlaneBands::holdAtMost(uint64_t bytes) {
  // One band at least: rows are copied one by one, and each would decode it again.
  cache_.setBudget(std::max(bytes, bandBytes()));
}

void PlaneBands::copy(int64_t plane, const Box3& box, size_t voxel_bytes, std::byte* out) {
  const size_t part_bytes = static_cast<size_t>(box.size().x) * voxel_bytes;
  for (int64_t y = box.lo.y; y < box.hi.y;) {
    const int64_t band = y / shape_.band_rows;
    const int64_t first = band * shape_.band_rows;
    const int64_t count = std::min(shape_.band_rows, shape_.height - first);
    const auto rows = cache_.get({plane, band}, bandBytes(), [&] {
      auto made = std::make_shared<Rows>(static_cast<size_t>(count * shape_.row_bytes));
      decode_(plane, first, count, *made);
      return decltype(cache_)::Loaded{std::move(made), bandBytes()};
    });
    for (const int64_t end = std::min(first + count, box.hi.y); y < end; ++y, out += part_bytes)
      std::memcpy(out,
                  rows->data() + (y - first) * shape_.row_bytes +
                      box.lo.x * static_cast<int64_t>(voxel_bytes),
                  part_bytes);
  }
}

}  // namespace sluice
