// NumberRange: the numbers that an option accepts. A plain value.
#pragma once

#include <cstdint>
#include <limits>

namespace sluice {

// Both ends are included unless `above_least` leaves the lower one out. An end that is the type's
// own does not limit anything, but infinities and NaN are never in range.
template <class Number>
struct NumberRange {
  Number least = std::numeric_limits<Number>::lowest();
  Number most = std::numeric_limits<Number>::max();
  bool above_least = false;

  bool holds(Number n) const {
    return n <= most && (above_least ? n > least : n >= least);  // false for NaN
  }
};

// The whole numbers of a range whose ends are whole.
inline NumberRange<int64_t> wholesIn(const NumberRange<double>& range) {
  NumberRange<int64_t> wholes;
  if (range.least > -0x1p63) wholes.least = static_cast<int64_t>(range.least);
  if (range.most < 0x1p63) wholes.most = static_cast<int64_t>(range.most);
  return wholes;
}

}  // namespace sluice
