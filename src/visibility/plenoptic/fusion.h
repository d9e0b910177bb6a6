// Block fusion: which co-spatial blocks of consecutive time steps are so alike in opacity that one
// representative block, and one opacity function, stands for all of them (Gao 2004, sections 5.1
// and 5.2).
//
// A representative block keeps two things instead of its values: the opacity of each voxel, for the
// difference, and the least extinction of each part (block_parts.h), for the function. Fusing two
// blocks takes the lower of both. This is equation 3 if the opacity rises with the value. If it
// does not, the paper's choice (the value with the lower opacity) would not be conservative: it
// could take two opaque values from different steps and miss the transparent values that each
// step's own voxels have between them. Plain values, any thread.
#pragma once

#include <span>
#include <vector>

#include "src/visibility/plenoptic/block_parts.h"

namespace sluice {

// A block at one time step, or the representative of several steps.
struct OpacityBlock {
  std::vector<float>
      opacity;  // opacity of each voxel at the corners of the block's cells, x fastest
  BlockParts parts;
};

// Made from device voxels, laid out as for blockParts(); `block` keeps its memory.
template <class T>
void fillOpacityBlock(const T* voxels, int64_t row_stride, int64_t plane_stride,
                      const PartGrid& grid, const ExtinctionTable& table, OpacityBlock& block);
void fillUniform(double device, const PartGrid& grid, const ExtinctionTable& table,
                 OpacityBlock& block);

// Equation 2: the mean of the squared distances of opacity (equation 1) over the voxels that are
// not empty in at least one of the two; 0 if there are none. Requires: equal sizes.
double blockDifference(std::span<const float> a, std::span<const float> b);

// Equation 3: `into` becomes the representative of both.
void fuse(OpacityBlock& into, const OpacityBlock& by);

}  // namespace sluice
