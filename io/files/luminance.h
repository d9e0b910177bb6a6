// The luminance of colors, for readers that deliver scalars.
#pragma once

#include <cstdint>

namespace sluice {

// 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709) of 8 or 16 bit numbers, rounded to nearest, in
// integers: a grey that is stored as R = G = B comes out as it was.
template <class T>
T luminance(T red, T green, T blue) {
  constexpr uint32_t kRed = 2126, kGreen = 7152, kBlue = 722, kSum = kRed + kGreen + kBlue;
  return static_cast<T>((kRed * red + kGreen * green + kBlue * blue + kSum / 2) / kSum);
}

}  // namespace sluice
