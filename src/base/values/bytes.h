// Sizes as people write and read them: 512M is 512 * 2^20 bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sluice {

// A whole or decimal number with an optional K, M, G or T (powers of 1024, case ignored, an "iB" or
// "B" after it allowed); nullopt when it is none, negative or over 2^63 - 1.
std::optional<uint64_t> parseBytes(std::string_view text);

// "17 B", "4.0 KiB", "1.5 GiB".
std::string formatBytes(uint64_t bytes);

}  // namespace sluice
