// Packs any VolumeSource as a store of compressed chunks that everybody reads: OME-Zarr 0.4 over
// Zarr 2, or 0.5 over Zarr 3 in shards, Blosc chunks, coarser levels if wanted
// (io/zarr/levels/level_maker.h), whose spreads go into a group of sluice's own
// (io/zarr/metadata/zarr_image.h). A stream: memory stays within the budget whatever the volume's
// size; restartable (io/zarr/packing/zarr_pack_folder.h); the same volume and options give the same
// bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/zarr/levels/level_maker.h"
#include "io/zarr/reading/zarr_codec.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

struct PackOptions {
  int64_t chunk_voxels = 64;  // a side
  // Voxels of a shard, multiples of a chunk: one file for many chunks, as Zarr 3 has them. Without,
  // a chunk is a file, in Zarr 2.
  std::optional<Vec3i> shard_voxels = {};
  BloscOptions blosc = {};
  uint64_t memory_bytes = uint64_t{256} << 20;  // limit for all threads together
  bool verify = false;                          // read again and compare with the source
  bool replace = false;                         // an existing store, at the end
  std::string unit = {};                        // unit of the spacing; empty: the source's
  bool with_levels = false;                     // also writes coarser levels
  std::optional<int64_t> levels = {};           // how many; without: see levelShapes()
  // How voxels of coarser levels are made, each way once: the first for the levels that all readers
  // see, the others for groups beside them (zarrLevelsFolder()). kMean is the first if it occurs.
  std::vector<Downsample> downsample = {Downsample::kMean};
  StopToken stop = {};  // ends packing by Interrupted
};

struct PackReport {
  int64_t chunks = 0;         // of all levels and their spreads
  int64_t empty_chunks = 0;   // all fill value: no file
  int64_t kept_chunks = 0;    // done by an earlier run that was interrupted
  int64_t files = 0;          // that hold chunks
  uint64_t voxel_bytes = 0;   // of the volume
  uint64_t stored_bytes = 0;  // of the chunk files, of coarser levels and spreads too
  std::vector<Vec3i> levels;  // voxels of each coarser level
  double pack_seconds = 0, verify_seconds = 0;
};

// A volume as its channels: a source each, of one layout. A span of one is a volume of one channel,
// whatever other channels its file has.
using ChannelSources = std::span<VolumeSource* const>;

// The decoded bytes of all channels and time steps. Throws Error if the channels differ in size,
// type, place or scaling of values, or have more voxels than a store may have, 2^59; files of a
// series may each have as many.
uint64_t packedBytes(ChannelSources channels);

// Writes all channels and time steps, the stored values as they are, to the folder `output`
// (NAME.zarr), which appears whole or not at all. The fill value is the background that the first
// source knows, else 0. Several channels become an axis of the store, named as their file names
// them. Throws Error if the output exists, the memory is too small (the message names the least), a
// read or a write fails, or a voxel differs when verified; throws Interrupted. The work done stays
// in NAME.zarr.partial for the next call.
PackReport packZarr(ChannelSources channels, const std::filesystem::path& output,
                    const PackOptions& options, WorkerPool& pool, ProgressMeter& progress);
// The same of one channel.
PackReport packZarr(VolumeSource& source, const std::filesystem::path& output,
                    const PackOptions& options, WorkerPool& pool, ProgressMeter& progress);

struct CheckReport {
  int64_t chunks = 0;               // files read
  uint64_t stored_bytes = 0;        // bytes of those files
  std::vector<std::string> faults;  // a line for each chunk that is damaged, missing or too many
};

// Reads every chunk of a packed store and compares its checksum. A shard that is missing is all
// fill value. Throws Error when the store cannot be opened or has no checksums, and Interrupted.
CheckReport checkZarr(const std::filesystem::path& folder, WorkerPool& pool,
                      ProgressMeter& progress, const StopToken& stop = {});

}  // namespace sluice
