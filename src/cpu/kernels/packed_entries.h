// PackedEntries: the four numbers of an entry of the look-up in 64 bits, so that one gather brings
// them all: drawing spends most of its time on gathers.
//
// Red is in the lowest 16 bits, then green, blue and opacity. 16 bits are a share of the table's
// greatest colour, or opacity, without a sign, as 4 bits of exponent and 12 of mantissa: to 1.2e-4
// of itself down to 6e-5, and to 7.5e-9 below. They are bits 11 to 26 of the float that is the
// share times 2^-112, so that unpacking takes a shift and a product.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "src/base/wide_vectors.h"

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
  static_assert(std::endian::native == std::endian::little);
  PackedEntries result;
  result.entries.resize(rgba.size() / 4);
  // The loops take the four numbers of an entry alike, so that they can be vectorized.
  inWideVectors([&result, rgba, most_opacity] {
    std::array<float, 4> most{}, least{};
    for (size_t i = 0; i < rgba.size(); i += 4)
      for (size_t c = 0; c < 4; ++c) {
        most[c] = std::max(most[c], rgba[i + c]);
        least[c] = std::min(least[c], rgba[i + c]);
      }
    for (size_t c = 0; c < 4; ++c) most[c] = std::max(most[c], -least[c]);
    const double color = std::max({most[0], most[1], most[2]});
    const double opacity = std::min(double{most[3]}, most_opacity);
    result.color_unit = static_cast<float>(std::ldexp(color, 112));
    result.opacity_unit = static_cast<float>(std::ldexp(least[3] < 0 ? -opacity : opacity, 112));
    // Where the greatest is 0, all are.
    const double color_divisor = color > 0 ? color : 1, opacity_divisor = opacity > 0 ? opacity : 1;
    const std::array<double, 4> divisor{color_divisor, color_divisor, color_divisor,
                                        opacity_divisor};
    auto* const out = reinterpret_cast<std::byte*>(result.entries.data());
    for (size_t i = 0; i < rgba.size(); i += 4) {
      std::array<uint16_t, 4> shares;
      for (size_t c = 0; c < 4; ++c) {
        const double share = std::abs(double{rgba[i + c]}) / divisor[c];
        shares[c] = packed(share > 1 ? 1 : share);
      }
      std::memcpy(out + 2 * i, shares.data(), sizeof shares);
    }
  });
  return result;
}

}  // namespace sluice
