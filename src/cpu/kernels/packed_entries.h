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

// Packs rgba entries, whose opacities all have one sign. Opacities beyond `most_opacity` are
// clamped to it.
inline PackedEntries packedEntries(std::span<const float> rgba, double most_opacity) {
  static_assert(std::endian::native == std::endian::little);
  PackedEntries result;
  result.entries.resize(rgba.size() / 4);
  inWideVectors([&result, rgba, most_opacity] {
    // The four numbers of an entry.
    using Floats [[gnu::vector_size(16)]] = float;
    using Doubles [[gnu::vector_size(32)]] = double;
    using Bits [[gnu::vector_size(16)]] = uint32_t;
    using Packed [[gnu::vector_size(8)]] = uint16_t;
    const auto entryAt = [rgba](size_t i) {
      Floats entry;
      std::memcpy(&entry, &rgba[i], sizeof entry);
      return entry;
    };
    Floats most{}, least{};
    for (size_t i = 0; i < rgba.size(); i += 4) {
      const Floats entry = entryAt(i);
      most = entry > most ? entry : most;
      least = entry < least ? entry : least;
    }
    most = -least > most ? -least : most;
    const double color = std::max({most[0], most[1], most[2]});
    const double opacity = std::min(double{most[3]}, most_opacity);
    result.color_unit = static_cast<float>(std::ldexp(color, 112));
    result.opacity_unit = static_cast<float>(std::ldexp(least[3] < 0 ? -opacity : opacity, 112));
    // Where the greatest is 0, all are.
    const double color_divisor = color > 0 ? color : 1, opacity_divisor = opacity > 0 ? opacity : 1;
    const Doubles divisor{color_divisor, color_divisor, color_divisor, opacity_divisor};
    const Doubles one{1, 1, 1, 1};
    auto* const out = reinterpret_cast<std::byte*>(result.entries.data());
    for (size_t i = 0; i < rgba.size(); i += 4) {
      Doubles share = __builtin_convertvector(entryAt(i), Doubles);
      share = (share < 0 ? -share : share) / divisor;
      share = share > 1 ? one : share;
      const Floats small = __builtin_convertvector(share * 0x1p-112, Floats);
      Bits bits;
      std::memcpy(&bits, &small, sizeof bits);
      bits = (bits + (1U << (kPackedShift - 1))) >> kPackedShift;
      const Packed packed = __builtin_convertvector(bits, Packed);
      std::memcpy(out + 2 * i, &packed, sizeof packed);
    }
  });
  return result;
}

}  // namespace sluice
