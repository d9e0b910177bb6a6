// The header of a NIfTI-1 or NIfTI-2 file, in either byte order.
//
// Supported fields: dim (up to three axes of space, the fourth is time; further ones must be 1),
// datatype and bitpix (u8, i8, u16, i16, u32, i32, f32, f64), vox_offset, pixdim (0 means 1),
// scl_slope and scl_inter (a slope of 0 or nan: not scaled), and the place in the world: sform if
// its code is above 0, else qform with its handedness in pixdim[0], else pixdim alone. The world is
// the file's (+x right, +y front, +z up: WorldFrame::kRas). A note calls this a guess if the file
// has pixdim alone. The world's units (xyzt_units) are not converted. The time between steps is
// pixdim[4] (0: not known) and that of the first toffset, in the unit of time of xyzt_units.
// Intents, slice timing, and cal_min/cal_max, a window for display, are ignored.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "io/headers/volume_description.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

// The bytes of a file that parseNiftiHeader needs: NIfTI-2's header.
constexpr size_t kNiftiHeaderBytes = 540;

struct NiftiHeader {
  VolumeDescription description;  // byte_skip is vox_offset, data_offset 0
  std::optional<TimeAxis> times;  // unset: not told, or one step
  bool pair = false;              // a .hdr whose voxels are in the .img of the same name
};

// Pure. `bytes` are the first of the file, decompressed; fewer than kNiftiHeaderBytes if the file
// is shorter. `path` names it in messages. Throws Error for anything malformed.
NiftiHeader parseNiftiHeader(std::span<const std::byte> bytes, const std::string& path);

}  // namespace sluice
