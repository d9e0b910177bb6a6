// The opacity functions of a series and their tree as bytes, for its index (Gao 2004, section 5.3).
// src/index/index_file.h documents where an index is kept and how a torn file is rejected.
//
// Bytes are validated as if they came from anyone: functions have the sizes that their blocks have,
// spans ascend, and the tree is the one that follows from the spans.
// Numbers are in this machine's byte order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/classify/transfer/transfer_function.h"
#include "src/index/index_file.h"
#include "src/index/series_pass.h"

namespace sluice {

// Version of the format: raised when the bytes, or the meaning of a function, change.
inline constexpr uint32_t kSeriesVersion = 2;

// The inputs besides the voxels that the functions follow from.
struct SeriesRecipe {
  TransferFunction transfer;  // its opacities; colours make no difference
  BlockLayout layout;
  int64_t steps = 1;
  double difference = 0.001;
  int64_t part_cells = 4;
  DirectionGrid directions;
  int detail_bits = kMostDetailBits;
};

// The inputs that are kept with the functions.
struct KeptSeries {
  TransferFunction transfer;      // its opacities
  ValueRange device_range;        // range over all steps, over which the table was made
  std::vector<int64_t> nonempty;  // blocks, of each step
  SeriesPassReport report;
  SeriesOpacity opacity;
};

// The key of the index: one file for each series, layout, transfer function and recipe.
IndexKey seriesKey(const VolumeSource& source, const SeriesRecipe& recipe);
// The opacity part of two transfer functions is the same.
bool sameOpacity(const TransferFunction& a, const TransferFunction& b);

// The bytes of an index of this recipe, with the transfer function in full.
std::vector<std::byte> serialize(const KeptSeries& series, const SeriesRecipe& recipe);
// nullopt when the bytes are none of this recipe. `any_transfer`: of any transfer function.
std::optional<KeptSeries> deserializeSeries(std::span<const std::byte> bytes,
                                            const SeriesRecipe& recipe, bool any_transfer = false);

}  // namespace sluice
