// PlaneBands: decoded rows of planes that lie in files one by one, for sources whose planes are
// decoded row after row or as a whole.
//
// A band is some rows of a plane. Bands go through a small cache, so that reading block by block
// (x, then y, then z) decodes each row about once, not once a block. Any thread; two that want the
// same band decode it once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "src/base/sources/stored_reads.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/single_flight_cache.h"

namespace sluice {

class PlaneBands {
 public:
  // All planes alike.
  struct Shape {
    int64_t height = 1;     // rows of a plane
    int64_t row_bytes = 1;  // of a row
    int64_t band_rows = 1;  // of a band; the last one of a plane may have fewer
    // Compressed pieces that are decoded as a whole, such as the tiles of a TIFF: their rows, and
    // how many lie side by side. Those of more rows than a band count as one for each band.
    int64_t unit_rows = 1, units_across = 1;
  };
  // Fills `rows` with the rows [first, first + count) of a plane, packed. Throws Error.
  using Decode =
      std::function<void(int64_t plane, int64_t first, int64_t count, std::span<std::byte> rows)>;

  // Holds a band until holdAtMost().
  PlaneBands(const Shape& shape, Decode decode);

  // Rows for a band of about half a MiB: whole units of `unit_rows`, which are best read together,
  // unless these are too large.
  static int64_t usualBandRows(int64_t height, int64_t row_bytes, int64_t unit_rows);

  uint64_t bandBytes() const { return static_cast<uint64_t>(shape_.band_rows * shape_.row_bytes); }
  // Limits the decoded rows; a band is held even if it is more.
  void holdAtMost(uint64_t bytes);

  // Copies boxes of a volume out of the planes that planeOf(z) tells, once for each z. A band that
  // several boxes share is decoded once for all of them. Requires: not empty.
  void copy(std::span<const RegionRead> regions, size_t voxel_bytes,
            const std::function<int64_t(int64_t z)>& planeOf);

  // The cost of reading these boxes, each once, with `held_bytes` of decoded rows kept in memory
  // (stored_reads.h).
  StoredReads storedReads(std::vector<Box3> boxes, uint64_t held_bytes) const;

 private:
  struct Key {
    int64_t plane = 0, band = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct KeyHash {
    size_t operator()(const Key& key) const {
      return std::hash<int64_t>()(key.plane) * 0x9e3779b97f4a7c15U + std::hash<int64_t>()(key.band);
    }
  };
  using Rows = std::vector<std::byte>;

  std::shared_ptr<const Rows> rowsOf(int64_t plane, int64_t band);
  // The pieces that are decoded for a band.
  int64_t unitsOf(int64_t band) const;

  const Shape shape_;
  const Decode decode_;
  SingleFlightCache<Key, const Rows, KeyHash> cache_{0, Held::kStays};
};

}  // namespace sluice
