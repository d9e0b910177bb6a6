// How large the blocks of a volume are that is smaller than a block: buffers, chunks and budgets
// need no more than the volume has.
#pragma once

#include <algorithm>
#include <cstdint>

#include "src/volume/block_layout.h"

namespace sluice {

// Voxels a side of the largest block, padding and ghost layers included: layout.size, or what the
// volume has along its longest axis with the ghost layers around it. `levels`: of resolution that
// may be drawn. With several, blocks stay whole, since those of coarser levels may reach beyond
// their own voxels (pyramid.h).
inline int64_t blockSide(const BlockLayout& layout, int64_t levels) {
  if (levels > 1) return layout.size;
  const Vec3i& dims = layout.dims;
  return std::min(layout.size, std::max({dims.x, dims.y, dims.z}) + 2 * layout.ghost);
}

}  // namespace sluice
