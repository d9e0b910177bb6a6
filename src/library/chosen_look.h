// What the options of the look make of a volume: the transfer function, whether it is lit, and the
// options that give the same again.
#pragma once

#include <string>
#include <vector>

#include "src/base/value_counts.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/device/frame_values.h"
#include "src/library/requests.h"
#include "src/render/camera.h"

namespace sluice {

struct ChosenLook {
  TransferFunction transfer;
  bool lit = false;
  // Of Lighting::flat_share: what is flat is measured against the colours' range where that is
  // known, since fill values stretch that of the values, and a step's differs from its series'.
  double flat_scale = 1;
  std::string options;                // "--map ct-bone --range 40,255 --opacities 40:0,... --shade"
  std::vector<std::string> warnings;  // one line each
};

// What is known of a volume's values: of all steps of a series, unless --this-step says otherwise.
struct ValueStatistics {
  ValueCounts counts;
  ValueRange range;  // least and greatest
};

// Throws Error from a transfer function's file.
ChosenLook chooseLook(const VolumeLayout& layout, const ValueStatistics& values,
                      const LookArguments& look, Mode mode);

// Where the ramp of benches begins without --threshold: a fifth up the range, whatever the
// automatic choice would be.
double plainThreshold(ValueRange range);

// Whether blocks carry a ghost layer: a picture of this look may take gradients. Throws Error from
// a transfer function's file.
bool needsGradients(const LookArguments& look, Mode mode);

// Whether the look follows from the values of the volume at all.
bool needsStatistics(const LookArguments& look);

// Slices of half a voxel where a pixel is smaller than a voxel, as the picture shows it then.
double stepFor(const View& view, const VolumeLayout& layout);

}  // namespace sluice
