// Tests of the classification share these transfer functions that show some values, and the blocks
// that show, checked in the other ways to ask for them.
#pragma once

#include <optional>
#include <vector>

#include "src/classify/blocks/classification.h"

namespace sluice {

// White, with these opacities.
TransferFunction transferOf(std::vector<OpacityPoint> opacities);
// Opaque from `lo` to `hi`.
TransferFunction band(double lo, double hi);
TransferFunction threshold(double t);

Box3 allCells(const BlockLayout& layout);

// The visible blocks. Their number and boxes are compared with countVisible() and ObjectBoxes.
VisibleBlocks classified(const SliceRanges& ranges, const TransferFunction& transfer,
                         std::optional<Box3> crop = std::nullopt, int threads = 2);

}  // namespace sluice
