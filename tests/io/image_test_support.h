// Support for the tests of VDB, slices and pictures: whole reads, Errors as text, damaged files.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/base/sources/volume_source.h"
#include "tests/support/error_of.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice {

inline std::vector<std::byte> readBox(VolumeSource& source, const Box3& box, int64_t time = 0) {
  std::vector<std::byte> bytes(static_cast<size_t>(box.count()) *
                               bytesPerVoxel(source.layout().type));
  source.readRegion(time, box, bytes);
  return bytes;
}
inline std::vector<std::byte> readAll(VolumeSource& source, int64_t time = 0) {
  return readBox(source, boxOf(source.layout().dims), time);
}
template <class T>
std::vector<T> valuesOf(const std::vector<std::byte>& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}
template <class T>
T valueAt(VolumeSource& source, Vec3i at) {
  return valuesOf<T>(readBox(source, {at, at + Vec3i{1, 1, 1}}))[0];
}

inline bool hasPythonModules(const std::string& modules) {
  return runCommand("/usr/bin/python3 -c 'import " + modules + "'").status == 0;
}

// Tries the file cut off at about `tries` lengths, and as often with some bytes changed from
// `first_byte` on: `use` must end in an Error or a result, never in a crash; a sanitizer sees more.
// Cut files that make no Error are counted.
template <class Use>
int surviveDamage(const std::filesystem::path& good, const std::filesystem::path& bad, size_t tries,
                  size_t first_byte, Use use) {
  const std::string bytes = readFile(good);
  int accepted_cuts = 0;
  for (size_t i = 0; i < tries; ++i) {
    writeFile(bad, std::string_view(bytes).substr(0, bytes.size() * i / tries));
    try {
      use(bad);
      ++accepted_cuts;
    } catch (const Error&) {
    }
  }
  std::mt19937 random(1);
  for (size_t i = 0; i < tries; ++i) {
    std::string changed = bytes;
    for (int n = 0; n < 3; ++n)
      changed[first_byte + random() % (bytes.size() - first_byte)] =
          static_cast<char>(random() & 0xffU);
    writeFile(bad, changed);
    try {
      use(bad);
    } catch (const Error&) {
    }
  }
  return accepted_cuts;
}

}  // namespace sluice
