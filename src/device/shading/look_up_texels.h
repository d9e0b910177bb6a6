// Turns a frame's look-up into a table of entries, and the numbers that modes other than composite
// accumulate into colours. Pure functions.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "src/base/values/shown_values.h"
#include "src/device/frame_values.h"

namespace sluice {

// The inputs that the texels of a frame's look-up follow from.
struct LookUpKey {
  LookUpPtr look_up;
  Mode mode = Mode::kComposite;
  Projection projection = Projection::kOrtho;
  double slice_length = 1;
  bool integrates = false;
  bool operator==(const LookUpKey&) const = default;
};
LookUpKey lookUpKey(const FrameSetup& setup);

// rgba of the look-up texture. Parallel views have one distance between samples, so the opacity is
// corrected and the colour premultiplied here; perspective ones get log2(1 - opacity) for a unit of
// slice_length and do the rest a pixel. Other modes get as alpha the part, 0 to 1, that a sample of
// the entry takes.
std::vector<float> lookUpTexels(const LookUpKey& key);

// Whether any entry has an opacity.
bool showsOpacities(const LookUp& look_up);
// The device values whose samples have an opacity, or at which surfaces are.
ShownValues shownValues(const LookUp& look_up);
// Device values beyond which none has: an entry of distance is added for rounding. The first is the
// greater one if no entry has an opacity.
std::array<double, 2> visibleValues(const LookUp& look_up);

// In place: turns the numbers of modes other than composite into their colours, premultiplied.
// Numbers 0 and 1 of a pixel are: maximum, the greatest value and its share of visibility; minimum,
// the least value and 1 - the greatest share; average, the sum of values times their shares and the
// sum of shares; attenuated maximum, the greatest dimmed place in FrameSetup::window, and as number
// 2 the greatest share; modes that colour by depth, the greatest depthCode() and the greatest
// share. A value of 1 there is `device_unit` device values; a value beyond 2e38
// means that nothing is seen.
void resolveMode(const FrameSetup& setup, double device_unit, std::span<float> rgba);
// Changes the numbers in place to those for a unit of 1.
void scaleValues(const FrameSetup& setup, double device_unit, std::vector<float>& rgba);

}  // namespace sluice
