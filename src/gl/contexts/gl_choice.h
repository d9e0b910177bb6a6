// GlChoice: how to reach OpenGL, for code that passes on a user's choice. No GL is needed to know
// it.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace sluice {

// The values of --gl. kAuto is the first that works of
//   1. EGL on a hardware device: a GPU samples an order of magnitude faster than any CPU;
//   2. OSMesa: the software renderer with the fewest parts (one library, no display, no driver
//      search, no second dispatch layer), so the one that fails least and repeats best;
//   3. EGL on whatever it offers: the same llvmpipe, for systems without OSMesa (Mesa 25.1 on).
// kEgl is the first that works of: each hardware device, each software device, the surfaceless
// platform, the default display.
enum class GlChoice { kAuto, kOsmesa, kEgl };
inline constexpr std::array kGlChoices = {GlChoice::kAuto, GlChoice::kOsmesa, GlChoice::kEgl};
constexpr std::string_view name(GlChoice choice) {
  constexpr std::array<std::string_view, kGlChoices.size()> kNames = {"auto", "osmesa", "egl"};
  return kNames[static_cast<size_t>(choice)];
}

// A flag for Mesa that pictures need, see context.h.
inline constexpr const char* kExactSampling = "no_aos_sampling";

}  // namespace sluice
