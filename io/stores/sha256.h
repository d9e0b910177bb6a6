// SHA-256 (FIPS 180-4), by which publishers of volumes tell whether a file is theirs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace sluice {

// One thread.
class Sha256 {
 public:
  void add(std::span<const std::byte> bytes);
  // 64 hexadecimal digits in lower case. To be called once, last.
  std::string finish();

 private:
  static constexpr size_t kBlockBytes = 64;

  void addBlock(const std::byte* block);

  std::array<uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                    0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, kBlockBytes> rest_{};  // not a whole block yet
  size_t rest_bytes_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace sluice
