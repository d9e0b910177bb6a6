// The other byte order.
#pragma once

#include <cstddef>
#include <span>

namespace sluice {

// Reverses the bytes of each word of `word_bytes` (2, 4 or 8; of others nothing is changed).
void swapBytes(std::span<std::byte> bytes, size_t word_bytes);

}  // namespace sluice
