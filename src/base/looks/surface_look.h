// Surfaces where the values of a volume pass a level: as an option says them, `300:0.4:ff8800`, and
// as devices draw them. Pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "src/base/values/vec.h"

namespace sluice {

// Surfaces that a picture shows together at the most.
inline constexpr size_t kMostSurfaces = 8;

struct SurfaceLook {
  double value = 0;
  double opacity = 1;      // 0 to 1
  std::string color = {};  // the name of a colour, or six hexadecimal digits; empty: not set
  friend bool operator==(const SurfaceLook&, const SurfaceLook&) = default;
};

// "300", "300:0.4", "300:0.4:green"; nullopt: no such text. A colour is a word of letters, digits
// and hyphens; whether there is one of that name is not checked.
std::optional<SurfaceLook> parseSurfaceLook(std::string_view text);
// The text that gives the look again.
std::string surfaceLookText(const SurfaceLook& look);

// A surface in device values. Its level lies a little below the value that was asked for, so that
// voxels that have that value exactly lie clearly on its upper side, however the arithmetic of a
// device rounds.
struct SurfaceLevel {
  double level = 0;
  double opacity = 1;  // wherever a ray meets the surface, whatever the angle
  Vec3d rgb;
  friend bool operator==(const SurfaceLevel&, const SurfaceLevel&) = default;
};

}  // namespace sluice
