// What a frame's look-up becomes as a table of entries, and what modes other than composite make of
// the numbers that they bring back. Pure functions.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

// What the texels of a frame's look-up follow from.
struct LookUpKey {
  LookUpPtr look_up;
  Mode mode = Mode::kComposite;
  Projection projection = Projection::kOrtho;
  double slice_length = 1;
  bool operator==(const LookUpKey&) const = default;
};
LookUpKey lookUpKey(const FrameSetup& setup);

// rgba of the look-up texture. Parallel views have one distance between samples, so the opacity is
// corrected and the colour premultiplied here; perspective ones get log2(1 - opacity) for a unit of
// slice_length and do the rest a pixel. Other modes get as alpha the part, 0 to 1, that a sample of
// the entry takes.
std::vector<float> lookUpTexels(const LookUpKey& key);

// Device values beyond which no entry has an opacity: entries are interpolated, and rounding may
// move by one more. The first is the greater one where none has.
std::array<double, 2> visibleValues(const LookUp& look_up);

// In place: from the numbers of modes other than composite to their colours, premultiplied. Of a
// pixel, 0 and 1 are: greatest value and part of what is seen; least value and 1 - the greatest
// part; sum of values times their parts and sum of parts. A value of 1 there is `device_unit`
// device values; one beyond 2e38 says that nothing is seen.
void resolveMode(const FrameSetup& setup, double device_unit, std::span<float> rgba);
// In place: the same numbers for a unit of 1.
void scaleValues(double device_unit, std::vector<float>& rgba);

}  // namespace sluice
