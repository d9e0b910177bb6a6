// The opacity functions of a series and their tree as bytes, for the index beside it (Gao 2004,
// section 5.3). Where and how an index is kept, and that a torn file is not believed, is
// src/index/index_file.h.
//
// What is read is checked as if it came from anyone: functions have the sizes that their blocks
// have, spans ascend, and the tree is that of the spans. In this machine's byte order. Pure
// functions, any thread.
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

// Of the bytes' meaning: goes up when they, or what a function is, change.
inline constexpr uint32_t kSeriesVersion = 2;

// What functions follow from beside the voxels.
struct SeriesRecipe {
  TransferFunction transfer;  // its opacities; colours make no difference
  BlockLayout layout;
  int64_t steps = 1;
  double difference = 0.001;
  int64_t part_cells = 4;
  DirectionGrid directions;
  int detail_bits = kMostDetailBits;
};

// What is kept with them.
struct KeptSeries {
  TransferFunction transfer;      // its opacities
  ValueRange device_range;        // of all steps, over which its table was made
  std::vector<int64_t> nonempty;  // blocks, of each step
  SeriesPassReport report;
  SeriesOpacity opacity;
};

// One file a series, layout, transfer function and way of making them.
IndexKey seriesKey(const VolumeSource& source, const SeriesRecipe& recipe);
// The opacity part of two transfer functions is the same.
bool sameOpacity(const TransferFunction& a, const TransferFunction& b);

std::vector<std::byte> serialize(const KeptSeries& series, const SeriesRecipe& recipe);
// nullopt when the bytes are none of this recipe. `any_transfer`: of any transfer function.
std::optional<KeptSeries> deserializeSeries(std::span<const std::byte> bytes,
                                            const SeriesRecipe& recipe, bool any_transfer = false);

}  // namespace sluice
