// OpenVDB files for the tests, with the values that OpenVDB itself states for each voxel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {

// The contents of a written grid; `values` are the voxels of `box` (index space), x fastest, as
// double.
struct WrittenGrid {
  Box3 active;  // the active voxels and tiles
  Box3 box;     // active and one voxel more on each side
  std::vector<double> values;
  int64_t leaves = 0;
  int64_t tiles = 0;  // tiles that differ from the background
};

// Writes a grid of scattered leaves, active and inactive tiles of several sizes, some of them equal
// to the background. `type`: float, half, double, int32, int64, bool, mask. `compression`:
// OpenVDB's flags (1 zip, 2 active values only, 4 blosc).
WrittenGrid writeMixedGrid(const std::filesystem::path& path, const std::string& type,
                           uint32_t compression = 6);

// Writes a grid "f" of floats with the given active voxels, background 0; does not return values.
void writePoints(const std::filesystem::path& path,
                 const std::map<std::array<int, 3>, float>& points);

// A grid "f" of one voxel (3, 4, 5) under the affine map whose rows are the steps of x, y, z and
// the origin.
void writeTransformed(const std::filesystem::path& path, const double (&rows)[4][3]);
void writeFrustum(const std::filesystem::path& path);

// Grids in this order: velocity (vec3s), id (int32), density (float, fog volume), density (double),
// nothing (float without active voxels). Voxel (0, 0, 0) of density is 2, of density[1] 3, of id 7.
void writeSeveral(const std::filesystem::path& path);

}  // namespace sluice
