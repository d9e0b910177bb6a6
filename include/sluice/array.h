// Voxels without a file: an array in your memory, or a function that gives them box by box.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace sluice {

// Size, type and place of such voxels.
struct ArrayLayout {
  std::array<int64_t, 3> dims = {};  // voxels along x, y, z
  std::string type = {};             // a name of VolumeOptions::type, in this machine's byte order
  int64_t time_steps = 1;
  std::array<double, 3> spacing{1, 1, 1};  // world units between neighbouring voxels
  std::array<double, 3> origin{0, 0, 0};   // world position of the first voxel
  // Directions of the world along which x, y and z run, not in one plane.
  std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::string unit = {};       // of spacing and origin
  std::string name = "array";  // for messages
};

// Bytes from a voxel to its neighbour along x, y and z, and to the next time step. Any sign; 0
// repeats a voxel.
using ArrayStrides = std::array<int64_t, 4>;

// Copies the voxels of a box from `lo` to `hi`, `hi` not included, of a time step to `out`: x
// fastest, packed. Several threads call at once. What it throws ends the call that needs the
// voxels.
using FillBox = std::function<void(int64_t time, const std::array<int64_t, 3>& lo,
                                   const std::array<int64_t, 3>& hi, std::span<std::byte> out)>;

}  // namespace sluice
