// Digest: 64 bits that stand for a sequence of bytes, to find out whether two machines or two times
// have the same data. It resists accidents, not attacks. Fast: about a word a multiplication.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace sluice {

class Digest {
 public:
  // Appends the bytes; how they are cut into calls makes a difference.
  void add(std::span<const std::byte> bytes) {
    mix(bytes.size());
    for (; bytes.size() >= sizeof(uint64_t); bytes = bytes.subspan(sizeof(uint64_t)))
      mix(wordOf(bytes.first(sizeof(uint64_t))));
    if (!bytes.empty()) mix(wordOf(bytes));
  }
  void add(std::string_view text) { add(std::as_bytes(std::span(text))); }
  // Numbers: structs may have padding between their members.
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T number) { add(std::as_bytes(std::span(&number, 1))); }

  uint64_t value() const { return state_; }

 private:
  static uint64_t wordOf(std::span<const std::byte> bytes) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data(), bytes.size());
    return word;
  }
  void mix(uint64_t word) {
    constexpr uint64_t kOdd = 0x9e3779b97f4a7c15;  // the golden section of 2^64
    constexpr int kHalf = 32;
    state_ = (state_ ^ word) * kOdd;
    state_ ^= state_ >> kHalf;
  }

  uint64_t state_ = 0x243f6a8885a308d3;  // pi
};

}  // namespace sluice
