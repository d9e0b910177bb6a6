// NumberSet: a set of the numbers from 0 to an end, a bit each, for long lists with repeats that
// are wanted in ascending order.
//
// Not to be shared between threads while it grows.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sluice {

class NumberSet {
 public:
  // 8 MiB of bits.
  static constexpr int64_t kMostNumbers = int64_t{1} << 26;

  // Holds numbers below `end`, which is at most kMostNumbers.
  explicit NumberSet(int64_t end) : words_(static_cast<size_t>((end + kBits - 1) / kBits)) {}

  void add(int64_t number) { word(number) |= bitOf(number); }
  // Adds `first` and those after it, without `end`.
  void add(int64_t first, int64_t end) {
    if (first >= end) return;
    const uint64_t from = ~uint64_t{0} << (first % kBits);
    const uint64_t to = ~uint64_t{0} >> (kBits - 1 - (end - 1) % kBits);
    if (first / kBits == (end - 1) / kBits) {
      word(first) |= from & to;
      return;
    }
    word(first) |= from;
    for (int64_t i = first / kBits + 1; i < (end - 1) / kBits; ++i) word(i * kBits) = ~uint64_t{0};
    word(end - 1) |= to;
  }

  // Ascending.
  std::vector<int64_t> numbers() const {
    size_t count = 0;
    for (const uint64_t word : words_) count += static_cast<size_t>(std::popcount(word));
    std::vector<int64_t> numbers;
    numbers.reserve(count);
    for (size_t i = 0; i < words_.size(); ++i)
      for (uint64_t left = words_[i]; left != 0; left &= left - 1)
        numbers.push_back(static_cast<int64_t>(i) * kBits + std::countr_zero(left));
    return numbers;
  }

 private:
  static constexpr int64_t kBits = 64;
  static uint64_t bitOf(int64_t number) { return uint64_t{1} << (number % kBits); }
  uint64_t& word(int64_t number) { return words_[static_cast<size_t>(number / kBits)]; }

  std::vector<uint64_t> words_;
};

}  // namespace sluice
