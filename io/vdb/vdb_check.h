// Whether an OpenVDB tree is built as its file says, before OpenVDB reads it.
//
// OpenVDB (10.0) copies as many bytes as a damaged length states into buffers of a fixed size, so a
// flipped bit can take the program down. This walks the nodes of a tree through its file, decoding
// nothing, and holds each length against the file and against what its place can take. What is
// compressed is left to the decompressors, which are given the right sizes and check for
// themselves.
#pragma once

#include <cstdint>
#include <vector>

#include "io/vdb/vdb_header.h"

namespace sluice {

// Where a tree lies in its file.
struct VdbTreeOnDisk {
  uint64_t tree_at = 0;      // behind the transform
  uint32_t compression = 0;  // OpenVDB's flags
  bool saved_as_half = false;
  // Where the values of each leaf start, in the file's order, and where the last ones end.
  std::vector<uint64_t> leaves_at;
};

// Checks all that OpenVDB will read of a grid: its tree, or that of the one among `grids` which it
// shares. Throws Error where the file is damaged or the tree is not of the standard shape. Reads
// the nodes, and of the leaves' values the lengths: a page or less for each leaf. Requires:
// value_type is float, double, int32, int64, bool or mask.
VdbTreeOnDisk checkVdbGrid(File& file, const std::vector<VdbGridInfo>& grids,
                           const VdbGridInfo& grid);

}  // namespace sluice
