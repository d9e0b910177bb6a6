// Whether an OpenVDB tree is built as its file says, before OpenVDB reads it.
//
// OpenVDB (10.0) copies as many bytes as a damaged length states into buffers of a fixed size, so a
// flipped bit can take the program down. This walks the nodes of a tree through its file, decoding
// nothing, and holds each length against the file and against what its place can take. What is
// compressed is left to the decompressors, which are given the right sizes and check for
// themselves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "io/vdb_header.h"

namespace sluice {

// What a tree takes in its file.
struct VdbTreeOnDisk {
  uint64_t node_bytes = 0;    // the transform and the tree without its leaves' values
  double bytes_per_leaf = 0;  // of the leaves' values, on average
};

// Checks all that OpenVDB will read of a grid: its tree, or that of the one among `grids` which it
// shares. Throws Error where the file is damaged or the tree is not of the standard shape. Reads
// the nodes, and of the leaves' values the lengths: a page or less for each leaf. Requires:
// value_type is float, double, int32, int64, bool or mask.
VdbTreeOnDisk checkVdbGrid(const std::filesystem::path& path, const std::vector<VdbGridInfo>& grids,
                           const VdbGridInfo& grid);

}  // namespace sluice
