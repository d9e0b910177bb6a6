// ExtinctionTable: the least opacity of an interval of values, as an extinction. The opacity of d
// voxel lengths of extinction k is 1 - exp(-k d), so that extinctions add up along a ray while
// transparencies multiply (Gao 2004, section 4, after Max 1995).
//
// Also how extinctions are kept: in one byte each, rounded down, so that a kept extinction never
// exceeds the true one. Immutable; any thread may read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/classify/transfer/opacity_table.h"

namespace sluice {

// The extinction of an opacity of 1 and near it: a voxel length leaves 1e-7 of what is behind.
inline constexpr float kMostExtinction = 16;

class ExtinctionTable {
 public:
  explicit ExtinctionTable(const OpacityTable& table);

  // The least extinction that a sample between device values lo <= hi may have, whatever its
  // gradient, a voxel length of the finest spacing; 0 if one of them stands for NaN. O(1).
  float leastIn(double lo, double hi) const;
  // The same for device values of one byte, from a table: cells of such blocks are looked up by the
  // million.
  float leastInBytes(uint8_t lo, uint8_t hi) const { return of_bytes_[size_t{lo} << 8U | hi]; }
  // The extinction of each entry of the table, whatever the gradient.
  const std::vector<float>& entries() const { return levels_.front(); }
  // Opacity of a device value at a voxel, whatever the gradient: Opa(v) of equation 1.
  float opacityOf(double device) const {
    return device < kLeastNumber ? 0 : opacity_[static_cast<size_t>(table_.entryOf(device))];
  }
  const ShownValues& shown() const { return table_.shown(); }

 private:
  static constexpr double kLeastNumber = -2e38;  // lesser values stand for NaN

  const OpacityTable table_;
  std::vector<float> opacity_;
  // levels_[n][i]: the least of entries i up to i + 2^n.
  std::vector<std::vector<float>> levels_;
  std::vector<float> of_bytes_;  // leastIn() of each pair: lo, then hi; 0 if lo > hi
};

// Extinctions as bytes: 0 is 0, and each further one is greater by a 14th of an octave, up to
// kMostExtinction.
uint8_t packExtinction(float extinction);  // the greatest that is not above it
float unpackExtinction(uint8_t packed);

}  // namespace sluice
