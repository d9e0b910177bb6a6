// GlChoice: how to reach OpenGL, for those who hand a user's choice on. No GL is needed to know it.
#pragma once

#include <optional>
#include <string_view>

namespace sluice {

// What --gl takes. kAuto is the first that works of
//   1. EGL on a hardware device: a GPU samples an order of magnitude faster than any CPU;
//   2. OSMesa: of the software ways the one with the fewest parts (one library, no display, no
//      driver search, no second dispatch layer), so the one that fails least and repeats best;
//   3. EGL on whatever it offers: the same llvmpipe, for systems without OSMesa (Mesa 25.1 on).
// kEgl is the first that works of: each hardware device, each software device, the surfaceless
// platform, the default display.
enum class GlChoice { kAuto, kOsmesa, kEgl };

// A flag for Mesa that pictures need, see context.h.
inline constexpr const char* kExactSampling = "no_aos_sampling";

}  // namespace sluice
