// The index: a volume's slice ranges as bytes, kept so that the next opening takes milliseconds.
// src/index/index_file.h documents where an index is kept and how a torn file is rejected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// Version of the format: raised when the bytes, or the meaning of SliceRanges, change.
inline constexpr uint32_t kSliceRangesVersion = 5;

// The bytes are in this machine's order.
std::vector<std::byte> serialize(const SliceRanges& ranges);
// nullopt when the bytes are no index of this layout and map, cut, or would lead a reader astray.
std::optional<SliceRanges> deserialize(std::span<const std::byte> bytes, const BlockLayout& layout,
                                       const ValueMap& map);

}  // namespace sluice
