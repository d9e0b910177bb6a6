// Raw volumes: voxels and nothing else; dimensions and type come from the user or the file's name.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "io/headers/decode_options.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// The user's options (--dims, --type, --endian, --skip, --spacing); unset ones are taken from the
// file's name (raw_name.h).
struct RawOptions {
  std::optional<Vec3i> dims;
  std::optional<int64_t> time_steps;  // a fourth number in --dims
  std::optional<VoxelType> type;
  std::optional<std::endian> byte_order;  // little-endian if neither option nor name tells
  int64_t skip_bytes = 0;                 // in front of the first voxel
  std::optional<Vec3d> spacing;           // 1, 1, 1
  DecodeOptions decode = {};
  // The user's options describe another volume, which this one is drawn over: messages ask for
  // none of them.
  bool is_over = false;
};

// The file must hold exactly the bytes of the dimensions, no more and no less. Throws Error with
// the arithmetic, and with dimensions that would fit, when it does not, when the dimensions or the
// type are missing, or an option makes no sense. A name that ends in ".gz" is decoded at the first
// read, and its size checked then.
std::unique_ptr<VolumeSource> openRaw(const std::filesystem::path& path,
                                      const RawOptions& options = {});

// Files of one slice each, z = 0 first. Throws Error if dims or type are missing, the number of
// files is not dims.z, or a file does not have the bytes of a slice behind its skip_bytes.
// Requires: files not empty, no time steps.
std::unique_ptr<VolumeSource> openRawSlices(const std::vector<std::filesystem::path>& files,
                                            const RawOptions& options);

}  // namespace sluice
