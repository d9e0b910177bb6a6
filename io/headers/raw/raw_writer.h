// Writes any VolumeSource to a file that everyone reads, as a stream: memory stays bounded whatever
// the volume's size, and a file appears whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

struct VolumeWriteOptions {
  uint64_t buffer_bytes = uint64_t{64} << 20;  // voxels held at once, at most
  // Runs of zeros are left out as holes, which read as zeros and take no room if the file system
  // has them.
  bool holes = true;
  StopToken stop = {};  // ends writing by Interrupted
};

// Writes all time steps, in this machine's byte order, the stored values as they are (a value scale
// of the source is not kept). The extension chooses the format: .raw (voxels alone), .nrrd, .nhdr
// (a header for NAME.raw), .mhd (the same). More than one time step makes a file a step, named as
// in src/base/files/numbered_name.h. Returns the files that were made, headers before their voxels.
// Throws Error (unknown extension, write failure) and Interrupted; files finished before stay. Adds
// the bytes to `progress`.
std::vector<std::filesystem::path> writeVolume(VolumeSource& source,
                                               const std::filesystem::path& path,
                                               const VolumeWriteOptions& options, WorkerPool& pool,
                                               ProgressMeter& progress);

// The files that it will make. Throws Error for an unknown extension.
std::vector<std::filesystem::path> filesToWrite(const VolumeLayout& layout,
                                                const std::filesystem::path& path);

}  // namespace sluice
