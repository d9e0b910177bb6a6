// Random: a small seeded generator with the same sequence on every machine and standard library,
// so that a simulation with random replacement can be repeated anywhere.
#pragma once

#include <cstdint>

#include "cache/policies/key_table.h"

namespace sluice {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next() { return mixBits(state_++); }
  // Uniform in [0, n) up to a bias below n / 2^32. Requires: 0 < n < 2^32.
  uint32_t below(uint64_t n) { return static_cast<uint32_t>(((next() >> 32) * n) >> 32); }

 private:
  uint64_t state_;
};

}  // namespace sluice
