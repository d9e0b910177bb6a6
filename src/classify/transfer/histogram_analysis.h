// HistogramAnalysis: which values of a volume are background and which are worth showing.
//
// A pure function of the counts, in steps that each leave a number to look at. The background is
// the dominating peak and the noise next to it. An object that stands out has a valley before it,
// and the threshold lies in that valley. If there is no valley (fog, a simulation), everything
// above the background and its noise is visible. If nearly all visible values form one hump, either
// the hump is what the volume shows (a solid block), or the few values far above it are (vessels).
#pragma once

#include "src/base/values/histogram.h"

namespace sluice {

enum class HistogramKind {
  kConstant,   // a single value, or nothing counted
  kAbove,      // background low, the visible values above it
  kBelow,      // background high (a bright field), the visible values below it
  kDiverging,  // background at zero, visible values on both sides
  kSolid,      // no background, or one of fill values: one broad hump of visible values
  kField,      // no background: values all over the range, as of a temperature
  kTail,       // like kAbove, but what stands out lies far above a hump that most voxels are in
};

struct HistogramFindings {
  HistogramKind kind = HistogramKind::kConstant;
  double background = 0;  // the most frequent value
  // The visible values lie beyond the threshold, away from the background, and up to `top`, which
  // 3 in 1000 of them exceed. kDiverging: both are distances from zero. kConstant: both the value.
  double threshold = 0;
  double top = 0;
  bool valley = false;  // the threshold lies in a valley, not at the edge of the background
};

HistogramFindings analyse(const Histogram& histogram);

}  // namespace sluice
