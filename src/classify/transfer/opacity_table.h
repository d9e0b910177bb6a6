// OpacityTable: a transfer function sampled over the device values of a volume, and which of these
// show something, see ShownValues.
//
// Classification reads the same table in which a device looks values up, so that a block called
// empty is empty in the picture. Entry i stands for the device value
//   lo + i * (hi - lo) / (entries - 1);
// a sample takes the nearest entry, or interpolates two if neighbours differ visibly. Values
// beyond the ends look as the ends do. For integers of a range below the entry count, each value
// falls on an entry exactly.
//
// A step of the opacity is a ramp over the few entries below it (a sixteenth to an eighth of a
// value of 8-bit data), since a value that rounding moves across a sharp one would flip a pixel
// between two ways of drawing the same sample. At the step itself the ramp has reached its upper
// end.
//
// A transfer function that looks at gradients adds rows of factors, one for each of its magnitudes
// and with one factor an entry; they are interpolated along both.
//
// Immutable after construction; any thread may read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "src/base/looks/surface_look.h"
#include "src/base/sources/volume_source.h"
#include "src/base/values/shown_values.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

class OpacityTable {
 public:
  // About `most_entries` entries over `device_range` (all device values of the volume), or over the
  // part of it in which the transfer function changes if that is less than a 64th.
  OpacityTable(const TransferFunction& transfer, const ValueMap& map, ValueRange device_range,
               int most_entries = 16384);

  int entries() const { return static_cast<int>(opacity_.size()); }
  // Device values of the first and the last entry.
  ValueRange deviceRange() const { return range_; }
  // How many entries below a step are part of its ramp.
  int stepEntries() const { return step_entries_; }
  // All device values of the volume.
  ValueRange volumeRange() const { return volume_range_; }
  // The nearest entry of a device value, clamped to the table.
  int entryOf(double device) const { return shown_.entryOf(device); }
  // Opacity of each entry for one voxel length of the finest spacing, not corrected for a step.
  const std::vector<float>& opacity() const { return opacity_; }
  // Values are names, see TransferFunction.
  bool labels() const { return labels_; }
  // Whether neighbouring entries differ by so much that a sample must interpolate.
  bool mustInterpolate() const { return must_interpolate_; }
  // r, g, b of each entry, not premultiplied, and its opacity.
  const std::vector<float>& rgba() const { return rgba_; }

  // The gradient magnitudes of the rows, in device values per voxel length of the finest spacing.
  // Empty: the gradient makes no difference.
  const std::vector<double>& magnitudes() const { return magnitudes_; }
  // Row after row; entries() a row, or one a row if none depends on the value.
  const std::vector<float>& factors() const { return factors_; }

  // Ascending by level.
  const std::vector<SurfaceLevel>& surfaces() const { return surfaces_; }
  // The device values that show something, surfaces too, whatever the gradient.
  const ShownValues& shown() const { return shown_; }
  // shown().anyIn(lo, hi) for samples whose gradient's magnitude is between `gradient_lo` and
  // `gradient_hi`, device values a voxel length. O(rows).
  bool showsAny(double lo, double hi, double gradient_lo, double gradient_hi) const;

 private:
  void sample(const TransferFunction& transfer, const ValueMap& map);
  void addGradients(const TransferFunction& transfer, const ValueMap& map);
  void addSurfaces(const TransferFunction& transfer, const ValueMap& map);
  bool isSurfaceEntry(int entry) const;
  double deviceAt(size_t entry) const {
    return range_.lo + (range_.hi - range_.lo) * static_cast<double>(entry) /
                           std::max(1.0, static_cast<double>(opacity_.size() - 1));
  }
  bool neighborsDiffer() const;

  ValueRange range_, volume_range_;
  std::vector<float> opacity_;
  std::vector<float> rgba_;
  int step_entries_ = 0;
  bool must_interpolate_ = false, labels_ = false;
  std::vector<SurfaceLevel> surfaces_;
  std::vector<int> surface_entries_;  // the nearest ones of their levels
  ShownValues shown_;
  std::vector<double> magnitudes_;
  std::vector<float> factors_;
  std::vector<ShownValues> shown_in_row_;  // those whose factor in the row is not 0 either
};

}  // namespace sluice
