// PackedEntries: the four numbers of an entry of the look-up in 64 bits, so that one gather brings
// them all: drawing spends most of its time on gathers.
//
// Red is in the lowest 16 bits, then green, blue and opacity. 16 bits are a share of the table's
// greatest colour, or opacity, without a sign, as 4 bits of exponent and 12 of mantissa: to 1.2e-4
// of itself down to 6e-5, and to 7.5e-9 below. They are bits 11 to 26 of the float that is the
// share times 2^-112, so that unpacking takes a shift and a product.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

inline constexpr int kPackedShift = 11;

struct PackedEntries {
  // Factors of the unpacked floats of a colour and of an opacity. The opacity's is negative for
  // perspective views, whose look-up holds log2(1 - opacity), never positive.
  float color_unit = 1, opacity_unit = 1;
  std::vector<int64_t> entries;
};

// Requires: 0 <= share <= 1.
inline uint16_t packed(double share) {
  const auto small = static_cast<float>(share * 0x1p-112);
  return static_cast<uint16_t>((std::bit_cast<uint32_t>(small) + (1U << (kPackedShift - 1))) >>
                               kPackedShift);
}

// Packs rgba entries, whose opacities all have one sign. Opacities beyond `most_opacity` are
// clamped to it.
inline PackedEntries packedEntries(std::span<const float> rgba, double most_opacity) {
  double color = 0, opacity = 0, sign = 1;
  for (size_t i = 0; i < rgba.size(); ++i) {
    double& most = i % 4 == 3 ? opacity : color;
    most = std::max(most, std::abs(static_cast<double>(rgba[i])));
    if (i % 4 == 3 && rgba[i] < 0) sign = -1;
  }
  opacity = std::min(opacity, most_opacity);
  const auto share = [](double of, double most) {
    return most > 0 ? std::min(std::abs(of) / most, 1.0) : 0.0;
  };
  PackedEntries result{static_cast<float>(std::ldexp(color, 112)),
                       static_cast<float>(sign * std::ldexp(opacity, 112)),
                       {}};
  result.entries.reserve(rgba.size() / 4);
  for (size_t i = 0; i < rgba.size(); i += 4) {
    uint64_t bits = packed(share(rgba[i + 3], opacity));
    for (size_t channel = 3; channel-- > 0;)
      bits = bits << 16 | packed(share(rgba[i + channel], color));
    result.entries.push_back(static_cast<int64_t>(bits));
  }
  return result;
}

}  // namespace sluice
