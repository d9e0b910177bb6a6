// Parses the shape and type of the voxels from the name of a raw file:
// "head_256x256x225_uint8.raw", as the public collections name them.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
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

}  // namespace sluice
