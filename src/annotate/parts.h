// The parts of an annotated picture and their places: orientation axes in the lower left corner,
// the scale bar in the lower right one, the colour bar above it along the right side.
#pragma once

#include "src/annotate/annotate.h"
#include "src/annotate/pen.h"

namespace sluice {

// Pixels; letters are this high.
double emOf(PictureSize size);

// The free margin on all sides, and the sizes of the parts, in ems.
inline constexpr double kFreeEms = 1;
inline constexpr double kAxesEms = 5;        // a side
inline constexpr double kScaleBarEms = 2.4;  // high
inline constexpr double kColorBarEms = 6;    // wide, its labels included

void drawOrientationAxes(Pen& pen, const Annotations& annotations);
void drawScaleBar(Pen& pen, const Annotations& annotations);
void drawColorBar(Pen& pen, const Annotations& annotations);

}  // namespace sluice
