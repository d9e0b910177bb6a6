#include "io/zarr/reading/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr uint32_t kPolynomial = 0x82f63b78;  // reflected
constexpr size_t kTables = 8;

// Table t: the remainder of a byte that t more bytes follow, so that eight bytes take one step.
constexpr auto kRemainders = [] {
  std::array<std::array<uint32_t, 256>, kTables> tables{};
  for (uint32_t byte = 0; byte < 256; ++byte) {
    uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? kPolynomial : 0);
    tables[0][byte] = crc;
  }
  for (size_t t = 1; t < kTables; ++t)
    for (size_t byte = 0; byte < 256; ++byte) {
      const uint32_t before = tables[t - 1][byte];
      tables[t][byte] = (before >> 8) ^ tables[0][before & 255];
    }
  return tables;
}();

}  // namespace

uint32_t crc32c(std::span<const std::byte> bytes) {
  uint32_t crc = ~uint32_t{0};
  for (; bytes.size() >= kTables; bytes = bytes.subspan(kTables)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data(), kTables);
    word ^= crc;
    crc = 0;
    for (size_t t = 0; t < kTables; ++t)
      crc ^= kRemainders[kTables - 1 - t][(word >> (8 * t)) & 255];
  }
  for (const std::byte byte : bytes)
    crc = (crc >> 8) ^ kRemainders[0][(crc ^ static_cast<uint32_t>(byte)) & 255];
  return ~crc;
}

}  // namespace sluice
