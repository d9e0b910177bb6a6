// Mode: how the samples along a ray make a pixel, and ModeTraits, which tell the rest of the
// program what a mode asks of it. A further mode is a row of the table, a case of Combining, and
// its kernel on each device.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "src/base/sources/volume_levels.h"

namespace sluice {

enum class Mode : uint8_t { kComposite, kMip, kMinip, kAverage, kAttenuatedMip, kDepthMip };

// How samples of a ray, and parts of a picture, are put together. The shaders know these by number.
enum class Combining : uint8_t {
  kBlend,     // colours, each under those in front of it
  kGreatest,  // the greatest value, and the greatest share of visibility
  kLeast,     // the least value, and the least of 1 - the share
  kSum,       // the sum of values times their shares, and of the shares
  // The greatest value, each dimmed by the values in front of it; how much those behind are dimmed;
  // and the greatest share. See FrameSetup::attenuation.
  kAttenuated,
};

struct ModeTraits {
  Mode mode = Mode::kComposite;
  Combining combining = Combining::kBlend;
  // Pixels hold colours and an opacity: light, gradients, labels and spreads show, and a depth can
  // be weighted by opacity. Otherwise they hold the numbers of `combining`, of which
  // resolveMode() makes a colour at the end.
  bool has_colors = true;
  // The order of boxes along a ray matters: parts of a picture are put together layer by layer.
  bool needs_order = true;
  // Matter in front hides matter behind it: rays end, boxes are culled, empty cells are leapt.
  bool hides = true;
  // Samples lie on voxel planes, see FrameSetup, and not on the view's slices.
  bool on_planes = false;
  // The greatest value is found together with its depth, which makes the colour: see depth_code.h.
  bool codes_depth = false;
  // The mode that takes this one's part if a greater device value stands for a lesser value.
  Mode for_negated = Mode::kComposite;
  // A pixel shows nothing if this number of it has its first value, which all its numbers have.
  size_t telling_number = 3;
  float first_value = 0;
  // How voxels of coarser levels must be made of the finest ones, and whether such levels show the
  // same as the finest, so that a picture may be drawn from them without being asked.
  LevelValues level_values = LevelValues::kMeans;
  bool suits_levels = true;
};

inline constexpr std::array<ModeTraits, 6> kModeTraits{{
    {.mode = Mode::kComposite},
    {.mode = Mode::kMip,
     .combining = Combining::kGreatest,
     .has_colors = false,
     .needs_order = false,
     .hides = false,
     .on_planes = true,
     .for_negated = Mode::kMinip,
     .telling_number = 0,
     .first_value = std::numeric_limits<float>::lowest(),
     .level_values = LevelValues::kMaxima},
    {.mode = Mode::kMinip,
     .combining = Combining::kLeast,
     .has_colors = false,
     .needs_order = false,
     .hides = false,
     .on_planes = true,
     .for_negated = Mode::kMip,
     .telling_number = 0,
     .first_value = std::numeric_limits<float>::max(),
     .level_values = LevelValues::kMinima},
    {.mode = Mode::kAverage,
     .combining = Combining::kSum,
     .has_colors = false,
     .needs_order = false,
     .hides = false,
     .for_negated = Mode::kAverage,
     .telling_number = 1,
     .suits_levels = false},
    {.mode = Mode::kAttenuatedMip,
     .combining = Combining::kAttenuated,
     .has_colors = false,
     .hides = false,
     .for_negated = Mode::kAttenuatedMip,
     .telling_number = 2,
     .suits_levels = false},
    {.mode = Mode::kDepthMip,
     .combining = Combining::kGreatest,
     .has_colors = false,
     .needs_order = false,
     .hides = false,
     .on_planes = true,
     .codes_depth = true,
     .for_negated = Mode::kDepthMip,
     .telling_number = 0,
     .first_value = std::numeric_limits<float>::lowest(),
     .level_values = LevelValues::kMaxima,
     .suits_levels = false},
}};

static_assert(
    [] {
      for (size_t row = 0; row < kModeTraits.size(); ++row)
        if (kModeTraits[row].mode != static_cast<Mode>(row)) return false;
      return true;
    }(),
    "a mode's row of the table stands at its number");

constexpr const ModeTraits& traitsOf(Mode mode) {
  return kModeTraits[static_cast<size_t>(mode)];
}

// Whether another distance of samples (FrameOptions::step_vox) makes another picture. Modes on
// planes take places between the planes only at distances below a voxel.
constexpr bool stepCounts(Mode mode, double step_vox) {
  return !traitsOf(mode).on_planes || step_vox < 1;
}

}  // namespace sluice
