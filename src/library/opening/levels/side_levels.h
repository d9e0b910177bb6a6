// SideLevels: coarser levels of a volume whose file has one level alone, or whose levels end too
// large, kept beside its index (src/index/index_file.h) as a Zarr group
// (io/zarr/packing/level_store.h).
//
// Means, maxima, minima and modes each have a group of their own. They are made of the file's
// coarsest level, or of the finest one if the file's levels hold something else. If they are made
// of a coarser level, means have no spreads: those would be the spreads of its own voxels, not of
// the finest ones.
//
// They are made in the pass that makes the min-max arrays, or in a pass of their own if the arrays
// are there already. An interrupted pass keeps what it has written. A group belongs to the state of
// the volume that an index file beside it names, with a digest of the group: after a change of
// either, the levels are made anew. Levels are a convenience: where they cannot be made or kept, a
// note says why, and pictures are drawn from level 0. Where a chunk turns out to be damaged as it
// is read, its voxels are made of those of level 0, and the next opening makes all levels anew.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/zarr/packing/level_store.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/index/index_file.h"
#include "src/library/requests.h"

namespace sluice {

// LevelsWish::kAuto makes levels of volumes with more voxels than this, 512 a side: a picture of
// 512 pixels a side shows smaller ones with a voxel a pixel or less, and needs no coarser level. If
// nobody has asked for levels, they must be cheap, too: of files, and of voxels of 8 or 16 bits.
inline constexpr int64_t kMostVoxelsWithoutLevels = int64_t{1} << 27;
bool isLarge(const VolumeLayout& layout);
// Levels of a file that end with more voxels than this, 128 a side, are continued by kAuto if
// somebody asks for levels: a first picture reads all of the coarsest one.
inline constexpr int64_t kMostVoxelsOfCoarsest = int64_t{1} << 21;

struct SideLevelsRequest {
  VolumeSource& source;    // the level of the file that they are made of
  bool continues = false;  // it is the coarsest of several
  std::string name;        // the volume's, for messages
  const IndexPlaces& places;
  int64_t time = 0;
  Downsample how = Downsample::kMean;
  LevelsWish wish = LevelsWish::kAuto;
  // Somebody asks for levels, and is told if the volume cannot have them.
  bool is_asked = false;
  WorkerPool& pool;
  uint64_t memory_bytes = UINT64_MAX;  // for the whole pass
  StopToken stop = {};
  // Told, before anything is written, what will be written and how large it is; and later, from any
  // thread, once, that a level is damaged. May be null.
  std::function<void(const std::string& line)> announce = {};
};

class SideLevels {
 public:
  // Opens the levels that are kept, or prepares to make them. Throws Interrupted.
  explicit SideLevels(const SideLevelsRequest& request);

  // Whether the volume has levels here, or will have them after the pass.
  bool any() const { return store_ != nullptr || writer_ != nullptr; }
  // The taker that the pass over the voxels has to be made for; null: no pass is needed.
  VoxelTaker* taker() const { return writer_.get(); }
  // Memory held during the pass.
  uint64_t heldBytes() const { return held_bytes_; }
  // To be called after the pass: keeps and opens the levels.
  void finish();
  // To be called in its place if the voxels cannot be read: removes what was made.
  void discard();

  // `source`, the whole volume, with the levels, if there are some. Called once, last.
  std::unique_ptr<VolumeSource> join(std::unique_ptr<VolumeSource> source);
  // Lines for people: why levels are missing or were not believed.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void open();
  void prepare(const SideLevelsRequest& request);

  const IndexPlaces places_;
  const VolumeLayout layout_;
  const std::string name_;
  const IndexKey key_;
  const int64_t time_;
  const Downsample how_;
  const std::function<void(const std::string& line)> announce_;
  std::filesystem::path index_file_;  // that names the state of the volume
  std::filesystem::path damaged_;     // the group, if it is not the one that was written
  std::unique_ptr<LevelStoreWriter> writer_;
  std::unique_ptr<LevelStore> store_;
  uint64_t held_bytes_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace sluice
