// The one way in: from what a user names on the command line to a VolumeSource.
//
// The reader is chosen by the file's first bytes, and by its extension where those say nothing.
// What can be named: a file (NRRD, MetaImage, NIfTI, OpenVDB, PNG, TIFF, raw), a folder of slices,
// an OME-Zarr image or Zarr array, a pattern ('slice-*.png', 'step_%03d.raw'), several of these,
// and "synth:KIND,..." volumes.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/channel_choice.h"
#include "io/headers/decode_options.h"
#include "src/base/stop_token.h"
#include "src/base/volume_source.h"

namespace sluice {

// What a user says beside the name. The fields that only some formats leave open are an
// Error with the others, so that nothing said is silently without effect.
struct OpenOptions {
  std::optional<Vec3i> dims = {};              // raw
  std::optional<int64_t> time_steps = {};      // raw
  std::optional<VoxelType> type = {};          // raw
  std::optional<std::endian> byte_order = {};  // raw
  int64_t skip_bytes = 0;                      // raw
  std::optional<Vec3d> spacing = {};           // any; replaces what the file says
  std::string grid = {};                       // OpenVDB; empty: see vdb_source.h
  ChannelWish channel = {};                    // Zarr, pages of a TIFF; without: the first
  // Zarr: decoded chunks kept at most, see zarr_source.h. Not something that a user says of a
  // volume, hence without effect on the others.
  uint64_t chunk_cache_bytes = uint64_t{32} << 20;
  // Compressed volumes of one stream; without effect on the others either. Its stop token is set to
  // the one below.
  DecodeOptions decode = {};
  // Ends what opening and reading take long for, by Interrupted.
  StopToken stop = {};
};

// One name. Throws Error in one line: what is missing, damaged or not understood, and what would
// be.
std::unique_ptr<VolumeSource> openVolume(const std::string& input, const OpenOptions& options = {});

// Several names, or one. Patterns are expanded in place. More than one file are: the slices of one
// volume, where they are pictures of one page, or raw files of which each has the bytes of a slice
// of `dims`; else the time steps of one volume, OpenVDB files in the box around all of theirs. They
// are taken in the order given, but for names that a shell has sorted as text: those in the order
// of their numbers (a note of the layout says so, and which number is missing). Requires: inputs
// not empty.
std::unique_ptr<VolumeSource> openVolume(const std::vector<std::string>& inputs,
                                         const OpenOptions& options = {});

// The first file that is missing within a series of one file a step; where none is, the file that
// would be step `time` if the series went on that far. nullopt: no such series, or nothing is
// missing. Throws Error for a step that cannot be opened.
std::optional<std::string> missingStep(VolumeSource& source, int64_t time);
// The time step of a series of a file a step whose file has `number` in its name. nullopt: none.
std::optional<int64_t> stepOfNumber(VolumeSource& source, int64_t number);

}  // namespace sluice
