// BoxVisibility: whether a box of cells shows anything under a transfer function, from the
// intervals of its values and of its gradient magnitudes (Li 2003, section 3.1). It turns growing
// boxes visible or skips them.
//
// Conservative: false only when every sample of every cell has opacity 0. Immutable; any thread may
// read.
#pragma once

#include "src/classify/boxes/brick_grid.h"
#include "src/classify/transfer/opacity_table.h"

namespace sluice {

class BoxVisibility {
 public:
  // `table` must outlive it. The axes of `layout`, of the volume, need not be at right angles.
  BoxVisibility(const OpacityTable& table, const VolumeLayout& layout);

  // Whether a sample in cells of this range may have an opacity above 0.
  bool shows(const CellRange& range) const;

 private:
  const OpacityTable& table_;
  // Bounds of a gradient's true length, as multiples of its length computed as if the axes were
  // orthogonal.
  double least_stretch_ = 1, most_stretch_ = 1;
  bool knows_gradients_ = false;
};

}  // namespace sluice
