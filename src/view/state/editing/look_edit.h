// Editing how channels and surfaces look. Pure functions from one look to the next.
#pragma once

#include <sluice/options.h>
#include <sluice/report.h>

#include <array>
#include <string>
#include <string_view>

namespace sluice {

using Rgb = std::array<double, 3>;  // 0 to 1, as shown on a screen

// The channel's own look within `look`, to be changed; an empty one is added if there is none.
LookOptions::Channel& channelOf(LookOptions& look, std::string_view channel);

// "GFP", or "channel 1" if the file gives no name.
std::string titleOf(const ShownLook::Channel& channel);

// The colour of a value.
Rgb colorAt(const ShownLook& look, double value);

// "3 (liver)" for a label that has a name, else the value as people write it.
std::string valueText(const ShownLook& look, double value);

// Whether the channels of a picture are blended as one medium.
bool blendsChannels(const LookOptions& look, const PictureOptions& picture, const ShownLook& shown);

// "40 at 1.5, 0, -3 mm (voxel 3, 0, 12)".
std::string readingText(const ShownLook& look, const VoxelProbe& reading, const std::string& unit);

// Whether another surface may be added to a picture with this look.
bool takesSurface(const LookOptions& look, const ShownLook& shown);
// One more surface: at the threshold if there is one, else in the middle of the values. Surfaces
// that it has already lie elsewhere.
LookOptions withSurface(LookOptions look, std::array<double, 2> values);

}  // namespace sluice
