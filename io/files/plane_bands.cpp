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

std::shared_ptr<const PlaneBands::Rows> PlaneBands::rowsOf(int64_t plane, int64_t band) {
  const int64_t first = band * shape_.band_rows;
  const int64_t count = std::min(shape_.band_rows, shape_.height - first);
  return cache_.get({plane, band}, bandBytes(), [&] {
    auto made = std::make_shared<Rows>(static_cast<size_t>(count * shape_.row_bytes));
    decode_(plane, first, count, *made);
    return decltype(cache_)::Loaded{std::move(made), bandBytes()};
  });
}

void PlaneBands::copy(std::span<const RegionRead> regions, size_t voxel_bytes,
                      const std::function<int64_t(int64_t z)>& planeOf) {
  Box3 all{{0, INT64_MAX, INT64_MAX}, {0, 0, 0}};
  for (const RegionRead& region : regions) {
    all.lo = min(all.lo, region.box.lo);
    all.hi = max(all.hi, region.box.hi);
  }
  const int64_t first_band = all.lo.y / shape_.band_rows * shape_.band_rows;
  for (int64_t z = all.lo.z; z < all.hi.z; ++z) {
    const int64_t plane = planeOf(z);
    for (int64_t first = first_band; first < all.hi.y; first += shape_.band_rows) {
      std::shared_ptr<const Rows> rows;
      for (const auto& [box, out] : regions) {
        const int64_t from = std::max(first, box.lo.y);
        const int64_t to = std::min(first + shape_.band_rows, box.hi.y);
        if (z < box.lo.z || z >= box.hi.z || from >= to) continue;
        if (rows == nullptr) rows = rowsOf(plane, first / shape_.band_rows);
        const size_t part_bytes = static_cast<size_t>(box.size().x) * voxel_bytes;
        const std::byte* row = rows->data() + (from - first) * shape_.row_bytes +
                               box.lo.x * static_cast<int64_t>(voxel_bytes);
        std::byte* to_row =
            out.data() +
            static_cast<size_t>((z - box.lo.z) * box.size().y + from - box.lo.y) * part_bytes;
        for (int64_t y = from; y < to; ++y, row += shape_.row_bytes, to_row += part_bytes)
          std::memcpy(to_row, row, part_bytes);
      }
    }
  }
}

int64_t PlaneBands::unitsOf(int64_t band) const {
  const int64_t first = band * shape_.band_rows;
  const int64_t end = std::min(first + shape_.band_rows, shape_.height);
  const int64_t rows = std::min(shape_.unit_rows, shape_.band_rows);
  return (ceilDiv(end, rows) - first / rows) * shape_.units_across;
}

StoredReads PlaneBands::storedReads(std::vector<Box3> boxes, uint64_t held_bytes) const {
  std::erase_if(boxes, [](const Box3& box) { return box.empty(); });
  std::ranges::sort(boxes, {}, [](const Box3& box) { return box.lo.z; });
  std::vector<int64_t> units;
  for (int64_t band = 0; band * shape_.band_rows < shape_.height; ++band)
    units.push_back(unitsOf(band));
  StoredReads reads;
  int64_t bands = 0;
  std::vector<Box3> active;
  std::vector<int64_t> uses(units.size());  // of each band of a plane
  // Planes between two ends of boxes are read alike.
  for (size_t next = 0; next < boxes.size() || !active.empty();) {
    const int64_t from = active.empty() ? boxes[next].lo.z : active.front().lo.z;
    for (; next < boxes.size() && boxes[next].lo.z == from; ++next) active.push_back(boxes[next]);
    int64_t end = next < boxes.size() ? boxes[next].lo.z : INT64_MAX;
    for (const Box3& box : active) end = std::min(end, box.hi.z);
    std::ranges::fill(uses, 0);
    for (const Box3& box : active)
      for (int64_t band = box.lo.y / shape_.band_rows; band * shape_.band_rows < box.hi.y; ++band)
        ++uses[static_cast<size_t>(band)];
    for (size_t band = 0; band < uses.size(); ++band) {
      if (uses[band] == 0) continue;
      bands += end - from;
      reads.chunks += (end - from) * units[band];
      reads.decodes += (end - from) * units[band] * uses[band];
    }
    for (Box3& box : active) box.lo.z = end;
    std::erase_if(active, [](const Box3& box) { return box.empty(); });
  }
  reads.decoded_bytes = static_cast<uint64_t>(bands) * bandBytes();
  reads.most_bytes = reads.decoded_bytes;
  // Boxes are read by several threads, so that no order of them is certain.
  if (reads.decoded_bytes <= held_bytes) reads.decodes = reads.chunks;
  return reads;
}

}  // namespace sluice
