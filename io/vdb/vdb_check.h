// Checks that an OpenVDB tree is built as its file declares, before OpenVDB reads it.
//
// OpenVDB (10.0) copies as many bytes as a damaged length states into buffers of a fixed size, so a
// flipped bit can take the program down. This check walks the nodes of a tree through its file
// without decoding anything. It holds each length against the file and against the size of its
// buffer. Compressed data is left to the decompressors, which get the right sizes and check for
// themselves.
#pragma once

#include <cstdint>
#include <vector>

#include "io/vdb/vdb_header.h"

namespace sluice {

// The place of a tree in its file.
struct VdbTreeOnDisk {
  uint64_t tree_at = 0;      // behind the transform
  uint32_t compression = 0;  // OpenVDB's flags
  bool saved_as_half = false;
  // Offsets of each leaf's values, in the file's order, and of the end of the last ones.
  std::vector<uint64_t> leaves_at;
};

// Checks everything that OpenVDB will read of a grid: its tree, or the tree of the one among
// `grids` with which it shares. Throws Error if the file is damaged or the tree is not of the
// standard shape. Reads the nodes, and of the leaves' values the lengths: a page or less for each
// leaf. Requires: value_type is float, double, int32, int64, bool or mask.
VdbTreeOnDisk checkVdbGrid(File& file, const std::vector<VdbGridInfo>& grids,
                           const VdbGridInfo& grid);

}  // namespace sluice
