// Makes a cut through the levels of resolution (level_cut.h): from the coarsest level on, each part
// that is too coarse is replaced by blocks of the next finer level, as far as the limits allow.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "src/render/blocks/cut/shown_levels.h"
#include "src/render/blocks/visible_blocks.h"

namespace sluice {

// The blocks of each volume, all of one cut. `shown`: each volume's levels under its look, which
// keep what they are asked. Requires: as of LevelCut::chooseTogether(), and one question at least.
std::vector<VisibleBlocks> makeCut(std::span<const BlockQuestion> questions,
                                   const std::vector<std::shared_ptr<ShownLevels>>& shown);

}  // namespace sluice
