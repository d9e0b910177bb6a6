#include "src/visibility/unpacked_parts.h"

#include <algorithm>

#include "src/visibility/part_detail.h"

namespace sluice {

const UnpackedParts::Parts& UnpackedParts::of(int32_t number, const OpacityFunction& function,
                                              size_t parts,
                                              const std::array<float, 256>& extinction) {
  constexpr size_t kBytes = size_t{4} << 20, kLeastPlaces = 16;
  if (places_.empty()) {
    const size_t a_place = std::max<size_t>(parts, 1) * 4 * (sizeof(uint32_t) + sizeof(float));
    places_.resize(std::max(kBytes / a_place, kLeastPlaces));
  }
  Parts& place = places_[static_cast<size_t>(number) % places_.size()];
  if (place.number == number && place.extinction.size() == 4 * parts) return place;
  place.number = number;
  place.cubes.assign(4 * parts, 0);
  place.extinction.assign(4 * parts, extinction[function.floor]);
  if (function.parts.empty()) return place;
  DetailReader in(function.parts, function.detail);
  for (size_t i = 0; i < parts; ++i) {
    const PartLevels part = in.next();
    for (size_t level = 0; level < 4; ++level) {
      place.cubes[4 * i + level] = part.cubes[level];
      place.extinction[4 * i + level] = extinction[part.levels[level]];
    }
  }
  return place;
}

}  // namespace sluice
