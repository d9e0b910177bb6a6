// Named colour maps: the values of --map and of a transfer function's file.
//
// viridis, inferno, plasma, magma, cividis, turbo, cool-warm and black-body are the published maps,
// within 2/255 a channel of their 256-entry tables; hot, grey, ct-bone, ct-soft-tissue, smoke,
// ember and plaster are plain ramps. None is a rainbow but turbo.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// The map that --threshold uses if none is named, and the automatic choice for a CT.
inline constexpr std::string_view kDefaultColorMap = "ct-bone";
// The automatic choice for values of unknown meaning.
inline constexpr std::string_view kNeutralColorMap = "plaster";

// All names, in the order in which help lists them.
std::span<const std::string_view> colorMapNames();

// A colour that is a map of its own, the same at all values: "green", "#ff8800" or "ff8800";
// nullopt for anything else.
std::optional<Vec3d> solidColor(std::string_view name);
// Their names, in the order in which help lists them.
std::span<const std::string_view> solidColorNames();

// The control points of a map over 0..1, the first at 0, the last at 1; both points of a plain
// colour are that colour. nullopt for an unknown name.
std::optional<std::vector<ColorPoint>> colorMap(std::string_view name);

// The same; throws Error, starting with `where` (the option or the file's field) and listing the
// names, for an unknown one.
std::vector<ColorPoint> requireColorMap(std::string_view name, const std::string& where);

// The colour of a label: the same for a number in every volume, and unlike the colours of
// neighbouring numbers.
Vec3d labelColor(double value);

// Points over 0..1 moved to lo..hi; 0 and 1 are met exactly. Requires: lo <= hi, both finite.
std::vector<ColorPoint> rescale(std::vector<ColorPoint> points, double lo, double hi);

}  // namespace sluice
