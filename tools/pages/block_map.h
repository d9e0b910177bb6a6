// Blocks by class as a picture: the block grid layer by layer along z, a square a block.
#pragma once

#include <optional>
#include <string>

#include "src/base/values/picture.h"
#include "src/base/values/vec.h"
#include "src/classify/blocks/classification.h"

namespace sluice {

struct BlockMap {
  Rgba8Picture picture;  // transparent between layers
  std::string caption;
};

// `grid`: blocks along each axis; ids count x fastest. If the grid has more blocks than a picture
// can show as squares of a pixel, only layers at even distances are drawn, and the caption says so;
// none if a single layer is too large.
std::optional<BlockMap> blockMap(Vec3i grid, const VisibleBlocks& blocks);

}  // namespace sluice
