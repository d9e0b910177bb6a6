// Files for the tests of the readers: a folder of their own, known voxels, programs that write.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/volume_source.h"

namespace sluice {

// A folder that is gone after the test.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  // Writes a file into it; returns its path.
  std::filesystem::path write(std::string_view name, std::string_view bytes) const;

 private:
  std::filesystem::path path_;
};

std::string readFile(const std::filesystem::path& path);

// The voxel that the tests' volumes have at a place: (3x + 5y + 7z + 11t) mod 251, or, for floats,
// that minus 100.25.
double knownVoxel(VoxelType type, Vec3i at, int64_t time = 0);
// A volume of such voxels, x fastest, in this machine's byte order.
std::string knownVoxels(VoxelType type, Vec3i dims, int64_t time_steps = 1);
// Each voxel's bytes in reverse.
std::string swapped(std::string bytes, VoxelType type);

// One box, read.
std::vector<std::byte> readBox(VolumeSource& source, int64_t time, const Box3& box);
// All time steps, read one by one.
std::string readAll(VolumeSource& source);
// Expects dimensions, type and all voxels to be those of knownVoxels.
void expectKnownVolume(VolumeSource& source, VoxelType type, Vec3i dims, int64_t time_steps = 1);

// The line of the Error that `action` must throw; a test failure when it throws none, or more than
// one line.
std::string errorOf(const std::function<void()>& action);

// Runs a shell command, its output thrown away; false when it fails.
bool runs(const std::string& command);
// Runs Python lines that have numpy as np, `known(type, x, y, z, t)` as above and the folder as
// `folder`.
bool runsPython(const TempFolder& folder, const std::string& lines);

}  // namespace sluice

// Skips the test, by name, where a program or module to check against is not installed.
#define SLUICE_NEEDS(what, command)                                     \
  do {                                                                  \
    if (!::sluice::runs(command)) GTEST_SKIP() << (what) << " missing"; \
  } while (false)
#define SLUICE_NEEDS_MODULE(module) \
  SLUICE_NEEDS("python module " module, "/usr/bin/python3 -c 'import " module "'")
#define SLUICE_NEEDS_FILE(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << (path) << " missing"
