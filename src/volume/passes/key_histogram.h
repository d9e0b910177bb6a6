// KeyHistogram: counts of device voxels whose range is not known yet.
//
// A voxel's key is its value for integers and the upper 18 bits of an order-preserving form of a
// float (sign, exponent and 9 bits of mantissa), so that one pass over a volume is enough; finish()
// makes entries of the keys that occur. Floats with few distinct values are remembered exactly, so
// that labels stay what they are. Not shared between threads.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/values/value_counts.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// The values of floats as long as there are no more than kMost.
class FewFloats {
 public:
  static constexpr size_t kMost = 256;

  void add(float value) {
    if (overflown_ || value == last_) return;
    last_ = value;
    const auto at = std::lower_bound(values_.begin(), values_.end(), value);
    if (at != values_.end() && *at == value) return;
    if (values_.size() == kMost) {
      overflown_ = true;
      values_.clear();
    } else {
      values_.insert(at, value);
    }
  }
  bool overflown() const { return overflown_; }
  void add(const FewFloats& other) {
    if (other.overflown_) {
      overflown_ = true;
      values_.clear();
    }
    for (const float value : other.values_) add(value);
  }
  // Ascending; empty when there are more.
  const std::vector<float>& values() const { return values_; }

 private:
  std::vector<float> values_;
  float last_ = kNotANumber;
  bool overflown_ = false;
};

template <class T>
class KeyHistogram {
 public:
  // Neighbours along x.
  void add(const T* voxels, int64_t count) {
    int64_t i = 0;
    if constexpr (kTables > 1) {
      // Runs of one value are counted as a whole: their sums would wait for each other. Between
      // them four counters wait less.
      constexpr int64_t kWord = sizeof(uint64_t);
      uint64_t run_word = 0, run = 0;
      const auto endRun = [&] {
        counts_[keyOf(static_cast<T>(run_word))] += std::exchange(run, 0);
      };
      for (; i + kWord <= count; i += kWord) {
        uint64_t word = 0;
        std::memcpy(&word, voxels + i, sizeof word);
        if (word == std::rotr(word, 8)) {
          if (word != run_word) endRun();
          run_word = word;
          run += kWord;
          continue;
        }
        for (int64_t j = 0; j < kWord; ++j)
          ++counts_[static_cast<size_t>(j % kTables) * kKeys + keyOf(voxels[i + j])];
      }
      endRun();
      for (; i + kTables <= count; i += kTables)
        for (int64_t table = 0; table < kTables; ++table)
          ++counts_[static_cast<size_t>(table) * kKeys + keyOf(voxels[i + table])];
    }
    for (; i < count; ++i) ++counts_[keyOf(voxels[i])];
    if constexpr (std::is_same_v<T, float>) {
      for (i = 0; i < count && !few_.overflown(); ++i)
        if (isNumber(voxels[i])) few_.add(voxels[i]);
    }
  }
  // The changes from one to the next of them.
  void addChanges(const T* voxels, int64_t count) {
    uint64_t changes = 0, jumps = 0;
    if constexpr (std::is_integral_v<T>) {
      // In runs so short that narrow sums hold them, which compilers turn into vector code.
      constexpr int64_t kRun = 240;
      for (int64_t first = 1; first < count; first += kRun) {
        const T* const to = voxels + first;
        const int64_t run = std::min(kRun, count - first);
        T run_changes = 0;
        for (int64_t i = 0; i < run; ++i)
          run_changes = static_cast<T>(run_changes + (to[i] != to[i - 1] ? 1 : 0));
        uint32_t run_jumps = 0;
        for (int64_t i = 0; i < run; ++i)
          run_jumps += static_cast<uint32_t>(std::abs(int32_t{to[i]} - int32_t{to[i - 1]}));
        changes += run_changes;
        jumps += run_jumps;
      }
    } else {
      for (int64_t i = 1; i < count; ++i) {
        changes += voxels[i] != voxels[i - 1] ? 1 : 0;
        jumps += jumpOf(voxels[i - 1], voxels[i]);
      }
    }
    changes_ += changes;
    jumps_ = jumpsTogether(jumps_, jumps);
  }
  void add(T value, uint64_t count) {
    counts_[keyOf(value)] += count;
    if constexpr (std::is_same_v<T, float>) {
      if (isNumber(value)) few_.add(value);
    }
  }
  void add(const KeyHistogram& other) {
    for (size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    changes_ += other.changes_;
    jumps_ = jumpsTogether(jumps_, other.jumps_);
    if constexpr (std::is_same_v<T, float>) few_.add(other.few_);
  }
  uint64_t total() const {
    uint64_t sum = 0;
    for (const uint64_t count : counts_) sum += count;
    return sum;
  }
  // Device values, NaN and infinities left out. Integers get an entry each if there are up to
  // kMostValueCounts of them. Requires: `range` holds every value added.
  ValueCounts finish(ValueRange range) const {
    std::vector<uint64_t> counts(kKeys, 0);
    for (size_t i = 0; i < counts_.size(); ++i) counts[i % kKeys] += counts_[i];
    const auto isUsed = [&](size_t key) { return counts[key] > 0 && !standsForNoNumber(key); };
    // Neighbouring keys share an entry if there are too many.
    const auto entriesOf = [&](int bits) {
      size_t used = 0, last = ~size_t{0};
      for (size_t key = 0; key < kKeys; ++key)
        if (isUsed(key) && key >> bits != last) {
          last = key >> bits;
          ++used;
        }
      return used;
    };
    int bits = 0;
    while (entriesOf(bits) > kMostValueCounts) ++bits;
    ValueCounts result;
    size_t last = ~size_t{0};
    for (size_t key = 0; key < kKeys; ++key) {
      if (!isUsed(key)) continue;
      const ValueCount one = entryOf(key, counts[key], range);
      if (!result.entries.empty() && (key >> bits == last || one.lo == result.entries.back().lo)) {
        result.entries.back().hi = one.hi;
        result.entries.back().count += one.count;
      } else {
        result.entries.push_back(one);
      }
      last = key >> bits;
    }
    result.changes = changes_;
    result.jumps = jumps_;
    return result;
  }

 private:
  static constexpr size_t kKeys = sizeof(T) == 1 ? 256 : sizeof(T) == 2 ? 65536 : 1 << 18;
  static constexpr int64_t kTables = sizeof(T) == 1 ? 4 : 1;
  static constexpr int kDropped = 14;  // bits of a float that its key leaves out

  static bool isNumber(float v) { return v > -kLargest && v < kLargest; }
  static uint64_t jumpOf(float a, float b) {
    constexpr float kMost = 0x1p32F;  // an infinite value must not fill the sum
    const float jump = std::abs(a - b);
    if (!(jump >= 0)) return 0;  // a neighbour is NaN
    return static_cast<uint64_t>(std::min(jump, kMost));
  }
  static uint32_t keyOf(T v) {
    if constexpr (sizeof(T) < 4) {
      return v;
    } else {
      const auto bits = std::bit_cast<uint32_t>(v);
      return ((bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U) >> kDropped;
    }
  }
  // NaN and infinities, as toDevice leaves them.
  static bool standsForNoNumber(size_t key) {
    if constexpr (sizeof(T) < 4) {
      return false;
    } else {
      return key == keyOf(kNotANumber) || key == keyOf(-kLargest) || key == keyOf(kLargest);
    }
  }
  ValueCount entryOf(size_t key, uint64_t count, ValueRange range) const {
    if constexpr (sizeof(T) < 4) {
      return {static_cast<double>(key), static_cast<double>(key), count};
    } else {
      double lo = floatOf(static_cast<uint32_t>(key << kDropped));
      double hi = floatOf(static_cast<uint32_t>((key + 1) << kDropped) - 1);
      // The keys of both zeros and of the values next to them.
      if (key + 1 == kKeys / 2 || key == kKeys / 2) lo = hi = 0;
      const auto& few = few_.values();
      const auto first = std::lower_bound(few.begin(), few.end(), lo);
      const auto last = std::upper_bound(few.begin(), few.end(), hi);
      if (first < last) {
        lo = *first;
        hi = *(last - 1);
      }
      return {std::clamp(lo, range.lo, range.hi), std::clamp(hi, range.lo, range.hi), count};
    }
  }
  static double floatOf(uint32_t ordered) {
    return std::bit_cast<float>((ordered & 0x80000000U) != 0 ? ordered & 0x7fffffffU : ~ordered);
  }

  std::vector<uint64_t> counts_ = std::vector<uint64_t>(kKeys * kTables);
  uint64_t changes_ = 0, jumps_ = 0;
  FewFloats few_;
};

}  // namespace sluice
