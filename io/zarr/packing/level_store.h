// LevelStore: the coarser levels of a volume, and their spreads if they are means, in a Zarr group
// of their own; for volumes whose format has one level. The group is an OME-Zarr image whose finest
// level is the volume's level 1, with voxels as `sluice pack --levels auto` makes them.
//
// LevelStoreWriter makes it of voxels that pass once. The group appears whole or not at all. What
// an interrupted run has done stays in NAME.zarr.partial and is kept by the next one, if it makes
// the same levels of the same volume.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/zarr/packing/level_packer.h"
#include "io/zarr/reading/zarr_source.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/voxel_taker.h"
#include "src/base/threads/progress_meter.h"

namespace sluice {

struct LevelStorePlan {
  Downsample how = Downsample::kMean;
  std::vector<LevelShape> levels;  // from fine to coarse; may be empty
  int64_t chunk_voxels = 0;        // a side
  uint64_t held_bytes = 0;         // memory of the writer
  uint64_t voxel_bytes = 0;        // of all levels and spreads, before they are compressed
};
// The levels of a volume, made in this way, in the largest chunks with which a writer with this
// many threads fits into `memory_bytes`; nullopt: none do.
std::optional<LevelStorePlan> planLevelStore(const VolumeLayout& layout, Downsample how,
                                             uint64_t memory_bytes, int threads);

// Whether levels can be made of a source in one pass: what it does not store is a number.
bool canMakeLevels(VolumeSource& source, int64_t time);

class LevelStoreWriter final : public VoxelTaker {
 public:
  // `source`: where the voxels come from, of which it only asks what they are. `output`: NAME.zarr,
  // which is replaced at the end. `pool` must outlive it. Throws Error: the folder cannot be
  // written, another process writes to it.
  LevelStoreWriter(VolumeSource& source, int64_t time, const std::filesystem::path& output,
                   const LevelStorePlan& plan, WorkerPool& pool, const StopToken& stop);

  int64_t side() const override { return plan_.chunk_voxels; }
  bool wantsLayer(int64_t z) override;
  void take(const VoxelPiece& piece) override;
  void layersBefore(int64_t end) override;

  // Brings the group to its name. Requires: all layers have come. False if a write has failed, here
  // or before: see fault().
  bool finish();
  // Removes what was written: the voxels cannot be read. Called last.
  void discard() { folder_->discard(); }
  // Why the levels cannot be kept, in one line; empty as long as they can.
  const std::string& fault() const { return fault_; }

 private:
  const LevelStorePlan plan_;
  const VolumeLayout layout_;
  const StopToken stop_;
  const std::vector<PackedArray> arrays_;
  std::string image_text_;
  std::vector<ZarrArrayTexts> array_texts_;
  std::unique_ptr<ZarrPackFolder> folder_;
  ChunkPacker chunks_;
  LevelPacker levels_;
  // Changed between layers only.
  bool is_wanted_ = true;
  std::string fault_;
};

// An open group. Any thread.
class LevelStore {
 public:
  // `finest`: the volume that they are levels of, made in the way `how`. Throws Error: a level or
  // its spreads are missing, damaged, or of another volume.
  LevelStore(const std::filesystem::path& folder, const VolumeLayout& finest, Downsample how);

  // From level 1 on; valid as long as the store.
  const std::vector<CoarserLevel>& levels() const { return levels_; }
  uint64_t storedBytesRead() const { return source_->storedBytesRead(); }
  // Decoded chunks of all levels and spreads together, as VolumeSource::holdAtMost() says.
  void holdAtMost(uint64_t bytes) { source_->holdAtMost(bytes); }
  // A digest of the group's metadata and checksums, which tells it from any other.
  static uint64_t digestOf(const std::filesystem::path& folder);

 private:
  std::unique_ptr<ZarrSource> source_;
  std::vector<CoarserLevel> levels_;
};

}  // namespace sluice
