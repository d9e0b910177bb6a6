// Rank indexes: "how much lies after this position?" over a growing line of positions, the trees
// under the stack distances. Position = time of last request; each key that has been requested
// holds one. Both offer the same members; not for other folders. One thread.
//
//   reset(n, first, w)   n positions, the first `first` of them taken, by weights w(p)
//   add(p, w), remove(p, w)   a key of weight w at position p comes or goes
//   after(p)             sum of the weights at positions > p
//
// UnitRank is for keys of weight 1: a bit a position, with counts over 64 (a byte), 512 (two
// bytes) and 16384 positions, the last in a Fenwick tree. A count over
// part of a word of small counts is one mask and one multiplication, so a query reads about four
// cache lines, whatever the number of keys. WeightRank is a Fenwick tree of sums.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace sluice {

class UnitRank {
 public:
  static constexpr bool kWeighted = false;
  template <class WeightAt>
  void reset(size_t positions, size_t first, WeightAt&& /*weight_at*/) {
    const size_t supers = positions / kSuper + 1;
    bits_.assign(supers * (kSuper / 64), 0);
    bytes_.assign(supers * (kSuper / 512), 0);
    lines_.assign(supers * (kSuper / 512 / 4), 0);
    supers_.assign(supers + 1, 0);
    total_ = first;
    for (size_t w = 0; w * 64 < first; ++w) {
      const uint64_t count = std::min<size_t>(64, first - w * 64);
      bits_[w] = ~uint64_t{0} >> (64 - count);
      bytes_[w / 8] += count << (w % 8 * 8);
      lines_[w / 32] += count << (w / 8 % 4 * 16);
      supers_[w / (kSuper / 64) + 1] += static_cast<uint32_t>(count);
    }
    for (size_t i = 1; i < supers_.size(); ++i) {
      const size_t parent = i + (i & (~i + 1));
      if (parent < supers_.size()) supers_[parent] += supers_[i];
    }
  }
  bool isTaken(size_t p) const { return (bits_[p / 64] >> (p % 64) & 1) != 0; }
  void add(size_t p, uint64_t /*weight*/) {
    bits_[p / 64] |= uint64_t{1} << (p % 64);
    bytes_[p / 512] += uint64_t{1} << (p / 64 % 8 * 8);
    lines_[p / 2048] += uint64_t{1} << (p / 512 % 4 * 16);
    for (size_t i = p / kSuper + 1; i < supers_.size(); i += i & (~i + 1)) ++supers_[i];
    ++total_;
  }
  void remove(size_t p, uint64_t /*weight*/) {
    bits_[p / 64] &= ~(uint64_t{1} << (p % 64));
    bytes_[p / 512] -= uint64_t{1} << (p / 64 % 8 * 8);
    lines_[p / 2048] -= uint64_t{1} << (p / 512 % 4 * 16);
    for (size_t i = p / kSuper + 1; i < supers_.size(); i += i & (~i + 1)) --supers_[i];
    --total_;
  }
  uint64_t after(size_t p) const {
    // The bits at p and before are those of its word, its 512, its 16384, and all 16384s before.
    const uint64_t in_word = bits_[p / 64] << (63 - p % 64);
    uint64_t before = countBits(in_word);
    before += sumBytes(bytes_[p / 512] & lowMask(p / 64 % 8 * 8));
    uint64_t lanes = lines_[p / 2048] & lowMask(p / 512 % 4 * 16);
    for (size_t i = p / kSuper * (kSuper / 2048); i < p / 2048; ++i) lanes += lines_[i];
    before += (lanes * 0x0001000100010001u) >> 48;
    for (size_t i = p / kSuper; i > 0; i &= i - 1) before += supers_[i];
    return total_ - before;
  }
  void prefetch(size_t p) const {
    __builtin_prefetch(&bits_[p / 64]);
    __builtin_prefetch(&bytes_[p / 512]);
  }

 private:
  static constexpr size_t kSuper = 16384;
  static constexpr uint64_t lowMask(size_t bits) { return (uint64_t{1} << bits) - 1; }
  // Written out, since baseline x86-64 has no instruction for it and the library call is slower.
  static constexpr uint64_t countBits(uint64_t x) {
    x -= (x >> 1) & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + ((x >> 2) & 0x3333333333333333u);
    return (((x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu) * 0x0101010101010101u) >> 56;
  }
  // Eight counts of at most 64: pairs first, since eight of them may pass 255.
  static constexpr uint64_t sumBytes(uint64_t bytes) {
    const uint64_t pairs = (bytes & 0x00ff00ff00ff00ffu) + ((bytes >> 8) & 0x00ff00ff00ff00ffu);
    return (pairs * 0x0001000100010001u) >> 48;
  }

  std::vector<uint64_t> bits_;
  std::vector<uint64_t> bytes_;   // eight counts over 64 positions each
  std::vector<uint64_t> lines_;   // four counts over 512 positions each
  std::vector<uint32_t> supers_;  // Fenwick tree over 16384 positions each, from 1
  uint64_t total_ = 0;
};

class WeightRank {
 public:
  static constexpr bool kWeighted = true;
  template <class WeightAt>
  void reset(size_t positions, size_t first, WeightAt&& weight_at) {
    sums_.assign(positions + 1, 0);
    total_ = 0;
    for (size_t p = 0; p < first; ++p) add(p, weight_at(p));
  }
  void add(size_t p, uint64_t weight) {
    for (size_t i = p + 1; i < sums_.size(); i += i & (~i + 1)) sums_[i] += weight;
    total_ += weight;
  }
  void remove(size_t p, uint64_t weight) {
    for (size_t i = p + 1; i < sums_.size(); i += i & (~i + 1)) sums_[i] -= weight;
    total_ -= weight;
  }
  uint64_t after(size_t p) const {
    uint64_t before = 0;
    for (size_t i = p + 1; i > 0; i &= i - 1) before += sums_[i];
    return total_ - before;
  }
  void prefetch(size_t /*p*/) const {}

 private:
  std::vector<uint64_t> sums_;  // from 1
  uint64_t total_ = 0;
};

}  // namespace sluice
