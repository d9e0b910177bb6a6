// automaticLook: a picture worth looking at, from the counts of the values alone. The choice is
// expressed in options that a person can give: a colour map, its begin and end, and opacities at a
// few values.
//
// - a CT in Hounsfield units: bone, or skin if there is no bone; padding does not count;
// - background and its noise at the low end: the values above are visible, coloured from the lowest
//   of them to the one that 3 in 1000 of them exceed;
// - most values near zero and tails on both sides (a statistic, a vorticity): both tails are
//   visible, cool below and warm above, zero grey whatever the range;
// - background at the high end (a bright field): the values below are visible;
// - no background at all: a solid block, unlit, in grey if the values form one broad hump
//   (electron microscopy), in colours if they lie all over their range (a temperature);
// - tissue with few values far above it (vessels with contrast agent): these alone;
// - two values: the surface between them, opaque;
// - labels: each its own colour, opaque;
// - a signed distance: a shell around zero;
// - one value: translucent everywhere.
// Fill values far off all others show nothing and do not count. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "src/base/values/value_counts.h"
#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

struct AutomaticOptions {
  // How many voxel lengths of the finest spacing a ray spends in the volume: about the mean of the
  // three sides. Opacities follow from it, so that one sees into a thick volume as into a thin one.
  double thickness_vox = 256;
  // The volume is a distance to a surface (an OpenVDB level set): show a shell around zero.
  bool signed_distance = false;
  // World units, if known: the shell of a signed distance is a few of these thick.
  double finest_spacing = 0;
  // Replaces the map that would be chosen; empty: chosen.
  std::string_view map = {};
};

struct AutomaticLook {
  // Its name describes the choice: "automatic above 40". Values have few digits, so that the
  // options that reproduce it are short.
  TransferFunction transfer;
  std::string map;       // empty for labels without one
  ValueRange map_range;  // lo > hi: the map is turned round
  bool lit = true;       // surfaces are worth lighting
};

// Throws Error when the map is unknown.
AutomaticLook automaticLook(const ValueCounts& counts, const AutomaticOptions& options = {});

// Whether the values are names: whole numbers, few of them or far between, that change seldom from
// voxel to voxel and by any amount.
bool areLabels(const ValueCounts& counts);
// The label that stands for nothing: 0 if it occurs, otherwise the most frequent value.
double backgroundLabel(const ValueCounts& counts);
// labelStyles() of the values that occur. Of more values than are counted one by one, all whole
// numbers in their range; throws Error if these are more than kMostLabels.
std::vector<LabelStyle> labelStylesOf(const ValueCounts& counts, std::string_view map = {});

}  // namespace sluice
