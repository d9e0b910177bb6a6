// The index: a volume's slice ranges as bytes, kept beside the file so that the next opening takes
// milliseconds. Where and how it is kept, and that a torn file is not believed, is
// src/index/index_file.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/volume/slice_ranges.h"

namespace sluice {

// Of the bytes' meaning: goes up when they, or what SliceRanges says, change.
inline constexpr uint32_t kSliceRangesVersion = 5;

// In this machine's byte order.
std::vector<std::byte> serialize(const SliceRanges& ranges);
// nullopt when the bytes are no index of this layout and map, cut, or would lead a reader astray.
std::optional<SliceRanges> deserialize(std::span<const std::byte> bytes, const BlockLayout& layout,
                                       const ValueMap& map);

}  // namespace sluice
