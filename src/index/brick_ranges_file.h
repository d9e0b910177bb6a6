// A volume's brick ranges as bytes, for its index (src/index/index_file.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/volume/ranges/brick_ranges.h"

namespace sluice {

// Version of the format: raised when the bytes, or the meaning of BrickRanges, change.
inline constexpr uint32_t kBrickRangesVersion = 3;

// The bytes are in this machine's order.
std::vector<std::byte> serialize(const BrickRanges& bricks);
// nullopt when the bytes are no bricks of a volume of `dims` voxels of this type, or cut.
std::optional<BrickRanges> deserializeBricks(std::span<const std::byte> bytes, Vec3i dims,
                                             DeviceType type);

}  // namespace sluice
