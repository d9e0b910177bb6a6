// CRC32C, the checksum of Castagnoli's polynomial, as Zarr 3 stores it behind chunks (RFC 3720,
// section 12.1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sluice {

// Takes any number of bytes; none give 0.
uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace sluice
