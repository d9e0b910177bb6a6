// The look that options select for a volume: the transfer function, whether it is lit, and the
// options that reproduce it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "src/base/values/value_counts.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/device/frame_values.h"
#include "src/library/requests.h"

namespace sluice {

struct ChosenLook {
  TransferFunction transfer;
  Mode mode = Mode::kComposite;  // the one that it was chosen for
  bool lit = false;
  // Factor of Lighting::flat_share. Flatness is measured against the colours' range if that is
  // known, since fill values stretch the range of the values, and a step's range differs from its
  // series'.
  double flat_scale = 1;
  std::map<double, std::string> label_names;  // of labels to which a table gives names
  double label_opacity = 1;                   // factor of the labels' own opacities
  std::string unlit_options;                  // "--map ct-bone --range 40,255 --opacities 40:0,..."
  std::vector<std::string> warnings;          // one line each

  // "--shade" or "--no-shade"; empty in modes without colours.
  std::string lightOption() const;
  // All options that give the look again.
  std::string options() const;
};

// Counts and range of a volume's values: of all steps of a series, unless --this-step is given.
struct ValueStatistics {
  ValueCounts counts;
  ValueRange range;  // least and greatest
};

// Throws Error from a transfer function's file.
ChosenLook chooseLook(const VolumeLayout& layout, const ValueStatistics& values,
                      const LookArguments& look, Mode mode);

// The value at which the ramp of benches begins without --threshold: a fifth up the range, whatever
// the automatic choice would be.
double plainThreshold(ValueRange range);

// Whether blocks carry a ghost layer: a picture of this look may take gradients. Throws Error from
// a transfer function's file.
bool needsGradients(const LookArguments& look, Mode mode);

// Whether the look follows from the values of the volume at all.
bool needsStatistics(const LookArguments& look);

}  // namespace sluice
