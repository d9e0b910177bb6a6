// Files for the tests of the readers: known voxels, and programs that write them.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "tests/support/error_of.h"
#include "tests/support/temp_folder.h"

namespace sluice {

// The voxel that the tests' volumes have at a place: (3x + 5y + 7z + 11t) mod 251, or, for floats,
// that minus 100.25.
double knownVoxel(VoxelType type, Vec3i at, int64_t time = 0);
// A volume of such voxels, x fastest, in this machine's byte order.
std::string knownVoxels(VoxelType type, Vec3i dims, int64_t time_steps = 1);
// Each voxel's bytes in reverse.
std::string swapped(std::string bytes, VoxelType type);

// The voxels of a box.
std::vector<std::byte> readBox(VolumeSource& source, int64_t time, const Box3& box);
// All time steps, read one by one.
std::string readAll(VolumeSource& source);
// Expects dimensions, type and all voxels of knownVoxels.
void expectKnownVolume(VolumeSource& source, VoxelType type, Vec3i dims, int64_t time_steps = 1);

// Runs a shell command, its output thrown away; false when it fails.
bool runs(const std::string& command);
// Runs Python lines that have numpy as np, `known(type, x, y, z, t)` as above and the folder as
// `folder`.
bool runsPython(const TempFolder& folder, const std::string& lines);

}  // namespace sluice

// Skips the test, by name, if a program or module to check against is not installed.
#define SLUICE_NEEDS(what, command)                                     \
  do {                                                                  \
    if (!::sluice::runs(command)) GTEST_SKIP() << (what) << " missing"; \
  } while (false)
#define SLUICE_NEEDS_MODULE(module) \
  SLUICE_NEEDS("python module " module, "/usr/bin/python3 -c 'import " module "'")
#define SLUICE_NEEDS_FILE(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << (path) << " missing"
