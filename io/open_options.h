// The user's options for opening a volume, in addition to its name.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>

#include "io/files/channel_choice.h"
#include "io/headers/decode_options.h"
#include "io/web/address.h"
#include "src/base/threads/stop_token.h"
#include "src/base/values/vec.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

// An option for one format is an Error with other formats, so that no option is silently without
// effect.
struct OpenOptions {
  std::optional<Vec3i> dims = {};              // raw
  std::optional<int64_t> time_steps = {};      // raw
  std::optional<VoxelType> type = {};          // raw
  std::optional<std::endian> byte_order = {};  // raw
  int64_t skip_bytes = 0;                      // raw
  std::optional<Vec3d> spacing = {};           // any; replaces the file's
  std::string grid = {};     // OpenVDB, DICOM; empty: see vdb_source.h, dicom_source.h
  ChannelWish channel = {};  // formats with channels; without: the first
  bool has_over = false;     // another volume is drawn over this one: messages say which is meant
  // Zarr: decoded chunks kept at most, see zarr_source.h. Not a property of a volume, hence without
  // effect on other formats.
  uint64_t chunk_cache_bytes = uint64_t{32} << 20;
  WebOptions web = {};  // addresses; without effect on the others
  // Compressed volumes of one stream; without effect on the others either. Its stop token is set to
  // the one below.
  DecodeOptions decode = {};
  // Ends lengthy opening and reading, by Interrupted.
  StopToken stop = {};
};

}  // namespace sluice
