// Parses the shape and type of the voxels from the name of a raw file:
// "head_256x256x225_uint8.raw", as the public collections name them.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "src/base/values/vec.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

struct RawName {
  std::optional<Vec3i> dims;
  std::optional<int64_t> time_steps;
  std::optional<VoxelType> type;
  std::optional<std::endian> byte_order;
};

// Looks at the parts of a file name (folders left out by the caller) between '_', '-', '.' and
// spaces, case ignored: "256x256x225" are dimensions, with a fourth number the time steps; "uint8",
// "i16", "f32" ... the type; after the dimensions also "uchar", "short", "float" ...; "le" or "be"
// after the dimensions the byte order. The last of each kind counts. Any text is allowed.
RawName parseRawName(std::string_view file_name);

// The part of the name that is not true of one time step of these voxels in this byte order, such
// as "16 x 8 x 8 voxels"; empty: there is none. A program that reads the file by its name believes
// it.
std::string falseInName(std::string_view file_name, Vec3i dims, VoxelType type, std::endian order);

}  // namespace sluice
