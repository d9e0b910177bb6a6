// ParaView's colour maps ("Export" in its list of presets) as transfer functions.
//
// ParaView interpolates colours in one of several spaces and bends opacities by a midpoint and a
// sharpness; ours are straight lines in RGB. Points are put in between until lines follow within
// 0.5/255 a channel, and within a 1000th of the step in opacity.
#pragma once

#include <string>
#include <string_view>

#include "src/base/files/json_field.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// `document`: an array of maps, or one. `map`: the Name of the wanted map, needed if there are
// several; if there is one, a colour map of ours that replaces its colours. A map over 0..1 or
// -1..1, as presets come, or outside `range` altogether is stretched over `range`, its opacities
// too; any other holds values as they are. Without opacities (Points) they rise from 0 to
// kDefaultOpacity. A map without a Name is called `where`. Throws Error.
TransferFunction paraviewTransfer(const JsonField& document, const std::string& where,
                                  ValueRange range, std::string_view map);

// ParaView's (VTK's) share of the way from one opacity point to the next at `t` (0..1): half of it
// is done at midpoint; sharpness goes from 0, a line, to 1, a step.
double bentWay(double t, double midpoint, double sharpness);

}  // namespace sluice
