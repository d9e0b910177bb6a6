#include "tests/io/headers/volume_files.h"

#include <algorithm>
#include <cstdlib>

namespace sluice {

double knownVoxel(VoxelType type, Vec3i at, int64_t time) {
  const double whole = static_cast<double>((3 * at.x + 5 * at.y + 7 * at.z + 11 * time) % 251);
  if (type == VoxelType::kI8) return whole - 125;
  return type == VoxelType::kF32 || type == VoxelType::kF64 ? whole - 100.25 : whole;
}

std::string knownVoxels(VoxelType type, Vec3i dims, int64_t time_steps) {
  std::string bytes;
  visitVoxelType(type, [&](auto tag) {
    for (int64_t t = 0; t < time_steps; ++t)
      for (int64_t z = 0; z < dims.z; ++z)
        for (int64_t y = 0; y < dims.y; ++y)
          for (int64_t x = 0; x < dims.x; ++x) {
            tag = static_cast<decltype(tag)>(knownVoxel(type, {x, y, z}, t));
            bytes.append(reinterpret_cast<const char*>(&tag), sizeof(tag));
          }
  });
  return bytes;
}

std::string swapped(std::string bytes, VoxelType type) {
  const auto size = static_cast<std::ptrdiff_t>(bytesPerVoxel(type));
  for (auto at = bytes.begin(); at < bytes.end(); at += size) std::reverse(at, at + size);
  return bytes;
}

std::vector<std::byte> readBox(VolumeSource& source, int64_t time, const Box3& box) {
  std::vector<std::byte> out(static_cast<size_t>(box.count()) *
                             bytesPerVoxel(source.layout().type));
  source.readRegion(time, box, out);
  return out;
}

std::string readAll(VolumeSource& source) {
  std::string bytes;
  for (int64_t t = 0; t < source.layout().time_steps; ++t) {
    const std::vector<std::byte> step = readBox(source, t, boxOf(source.layout().dims));
    bytes.append(reinterpret_cast<const char*>(step.data()), step.size());
  }
  return bytes;
}

void expectKnownVolume(VolumeSource& source, VoxelType type, Vec3i dims, int64_t time_steps) {
  const VolumeLayout& layout = source.layout();
  EXPECT_EQ(name(layout.type), name(type));
  EXPECT_TRUE(layout.dims == dims)
      << layout.dims.x << " x " << layout.dims.y << " x " << layout.dims.z;
  EXPECT_EQ(layout.time_steps, time_steps);
  if (testing::Test::HasNonfatalFailure()) return;
  EXPECT_TRUE(readAll(source) == knownVoxels(type, dims, time_steps)) << "voxels differ";
}

bool runs(const std::string& command) {
  return std::system(("(" + command + ") >/dev/null 2>&1").c_str()) == 0;
}

bool runsPython(const TempFolder& folder, const std::string& lines) {
  const std::string prelude =
      "import numpy as np\n"
      "folder = '" +
      folder.path().string() +
      "/'\n"
      "def known(kind, *dims):\n"
      "    f = lambda x, y, z=0, t=0: (3*x + 5*y + 7*z + 11*t) % 251\n"
      "    whole = np.fromfunction(f, dims)\n"
      "    kind = np.dtype(kind)\n"
      "    return (whole - (100.25 if kind.kind == 'f' else 125 if kind == np.int8 else 0))"
      ".astype(kind)\n";
  const std::filesystem::path script = folder.write("script.py", prelude + lines);
  return std::system(("/usr/bin/python3 " + script.string() + " >" +
                      (folder / "script.log").string() + " 2>&1")
                         .c_str()) == 0;
}

}  // namespace sluice
