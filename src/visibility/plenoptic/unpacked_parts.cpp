#include "src/visibility/plenoptic/unpacked_parts.h"

#include "src/visibility/plenoptic/part_detail.h"

namespace sluice {

const UnpackedParts::Parts& UnpackedParts::of(int32_t number, const OpacityFunction& function,
                                              size_t parts,
                                              const std::array<float, 256>& extinction) {
  if (places_.empty()) places_.resize(places(parts));
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
