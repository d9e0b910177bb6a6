// IntegratedLook: the colours and opacities of a look-up, summed over its entries, so that two
// reads give the mean over all values between two. Devices draw pre-integrated pictures with it
// (FrameSetup::integrates).
//
// Between two samples along a ray the value is taken to change linearly, so that each value between
// them lasts equally long (Roettger 2000; Engel 2001). The opacity of the way follows from the mean
// extinction, and its colour is the mean colour weighted by the extinction. Nothing is left out
// between the samples, however thin a part of the transfer function is.
//
// An extinction is -log2(1 - opacity) of a unit length, at most kMostExtinctionBits. Sums are whole
// numbers: the difference of two is exact even if it is small beside both.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

inline constexpr double kMostExtinctionBits = 16;
// Values are at most so many entries beyond the table: single precision keeps their fraction.
inline constexpr float kMostEntriesBeyond = 4e6F;

struct IntegratedLook {
  // Two rows of four numbers an entry, at least two entries: the sums below it of extinction times
  // red, green and blue, and of extinction; and the same four of the entry itself. Between two
  // entries sums are linear, and beyond the ends they go on as they do there.
  std::vector<int32_t> sums;
  double unit = 1;  // extinction times entries that a sum of 1 stands for
  // The entry of a value: value * entries_a_value + first.
  double entries_a_value = 0, first = 0;
  // Two values less than so many entries apart are one: it looks as the entries around it, linear
  // in between, and as one of them if that is nearer than `near_entry`. So a step of the transfer
  // function at a value shows there as it does in a single sample. Both are well above the rounding
  // of single precision, which would put such a value on either side of the step.
  double one_value = 0.125, near_entry = one_value / 8;

  int entries() const { return static_cast<int>(sums.size() / 8); }
};
IntegratedLook integratedLook(const LookUp& look_up);

}  // namespace sluice
