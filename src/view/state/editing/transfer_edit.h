// Editing how values look: thresholds, points of opacity over values, window and level. Pure
// functions from one look to the next.
#pragma once

#include <sluice/options.h>
#include <sluice/report.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

using OpacityPoints = std::vector<LookOptions::Opacity>;  // ascending by value

// A ramp from this value on. A ramp keeps the range that the user gave it.
LookOptions withThreshold(LookOptions look, double threshold);

// The values that the colours span, of a volume with this range: those of a ramp begin at its
// threshold, unless the user gives a range.
std::array<double, 2> colorsOf(const LookOptions& look, std::array<double, 2> range);

// The same look by points of opacity, a map and a range, for editing; a look by points stays as it
// is. A look from a file keeps the file for its colours.
LookOptions byPoints(const LookOptions& look, const ShownLook& shown, std::array<double, 2> range);

// The value that follows an option in a text of options ("--map ct-bone"), without the quotes of a
// shell; empty if the option is not there.
std::string wordAfter(std::string_view options, std::string_view option);

// Opacities of a voxel are small numbers; the plot draws their cube root.
double heightOf(double opacity);  // 0 to 1
double opacityAtHeight(double height);

// The point nearest to a place, both given as shares (0 to 1) of the value range and of the height,
// within `reach` of it in both; the later of equals.
std::optional<size_t> pointAt(const OpacityPoints& points, std::array<double, 2> range,
                              double share, double height, double reach_share, double reach_height);
// Puts a point among the others; its position.
size_t addPoint(OpacityPoints& points, double value, double opacity);
// Moves a point between its neighbours, and its opacity within 0..1. Requires: index <
// points.size().
void movePoint(OpacityPoints& points, size_t index, double value, double opacity);
// False, and nothing is done, if fewer than two points would be left, which a look needs.
bool removePoint(OpacityPoints& points, size_t index);

// Window and level as radiologists drag them: to the right widens the window, up lowers the level.
// `dx` and `dy` are shares of the pane; `all` is the least and greatest value.
std::array<double, 2> windowDragged(std::array<double, 2> range, double dx, double dy,
                                    std::array<double, 2> all);

}  // namespace sluice
