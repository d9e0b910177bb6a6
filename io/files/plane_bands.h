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
#include <span>
#include <vector>

#include "src/base/threads/single_flight_cache.h"
#include "src/base/values/vec.h"

namespace sluice {

class PlaneBands {
 public:
  // All planes alike.
  struct Shape {
    int64_t height = 1;     // rows of a plane
    int64_t row_bytes = 1;  // of a row
    int64_t band_rows = 1;  // of a band; the last one of a plane may have fewer
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

  // Copies the voxels of `box` in x and y out of a plane to `out`, packed. Requires: not empty.
  void copy(int64_t plane, const Box3& box, size_t voxel_bytes, std::byte* out);

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

  const Shape shape_;
  const Decode decode_;
  SingleFlightCache<Key, const Rows, KeyHash> cache_{0, Held::kStays};
};

}  // namespace sluice
