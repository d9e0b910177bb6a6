// ColorRamp: a look-up of one colour whose opacity rises along a smooth curve, as the channels of a
// microscope have it, as a few numbers. Kernels compute it faster than they read a table: of
// several channels the tables fill the processor's second cache.
#pragma once

#include <array>
#include <optional>
#include <span>

namespace sluice {

// With t = clamp((entry - first) * scale + offset, 0, 1), the fourth number of a whole entry, its
// opacity or the logarithm that perspective views have in its place, is t * (curve[0] + t *
// (curve[1] + t * curve[2])). Entries before `first` show nothing, and t is exactly 0: offset <=
// scale. Single precision has the distance to `first` exactly, and so small opacities as well as
// great ones.
struct ColorRamp {
  float first = 0, scale = 0, offset = 0;
  std::array<float, 3> curve{};
  std::array<float, 3> rgb{};
  bool is_premultiplied = false;  // the colours of the entries are `rgb` times the opacity
};

// The ramp that these entries, rgba as lookUpTexels() has them, follow closely, if there is one.
// Pure function.
std::optional<ColorRamp> colorRamp(std::span<const float> rgba);

}  // namespace sluice
