// ChunkedSource: an array of chunks, or an image of several levels of them, as a VolumeSource:
// Zarr, N5, HDF5.
//
// - Level 0 is the volume, the others are its coarser levels, as far as their arrays are there and
//   fit what is said of them (io/files/level_places.h); a note names each that is left out.
// - Missing chunks are the fill value, and known as such: occupancy() has the boxes of the others.
// - A few decoded chunks are kept (io/zarr/reading/zarr_chunk_cache.h), as neighbouring blocks
//   share them. All levels of an image and their spreads share one limit, which is the image's:
//   levels are not used evenly, so that parts of it would be too small for one and idle for
//   another.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "io/files/channel_choice.h"
#include "io/zarr/metadata/zarr_image.h"
#include "io/zarr/reading/chunked_array.h"
#include "io/zarr/reading/zarr_chunk_cache.h"
#include "src/base/sources/level_kinds.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/stored_reads.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

struct ChunkedOptions {
  ChannelWish channel = {};
  // Limit for decoded chunks; the least that ZarrChunkCache holds is held even if it is more.
  uint64_t chunk_cache_bytes = uint64_t{32} << 20;
};

class ChunkedSource : public VolumeSource,
                      public ChanneledSource,
                      public TimedSource,
                      public LeveledSource,
                      public LevelKinds,
                      public UnitSource,
                      public StoredSource {
 public:
  // Throws Error: an array that cannot be opened, --channel without such an axis.
  explicit ChunkedSource(const ChunkedVolume& volume, const ChunkedOptions& options = {});
  ~ChunkedSource() override;
  ChunkedSource(const ChunkedSource&) = delete;
  ChunkedSource& operator=(const ChunkedSource&) = delete;

  const VolumeLayout& layout() const override { return view_.layout; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  void readRegions(int64_t time, std::span<const RegionRead> regions) override;
  // nullopt when no chunk is missing. The background may be NaN or infinite.
  std::optional<Occupancy> occupancy(int64_t time) override;
  std::string identity() const override { return identity_; }
  std::span<const std::string> channelNames() const override { return channel_names_; }
  std::span<const StoredLook> channelLooks() const override { return channel_looks_; }
  std::optional<TimeAxis> times() const override { return view_.times; }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_above_; }
  std::span<const CoarserLevel> levelsOfKind(LevelValues values) const override;
  // Spreads of the first level's own voxels, which a group of the coarser levels of another volume
  // has (io/zarr/packing/level_store.h); null: none.
  VolumeSource* spreads() const { return spreads_.get(); }
  std::vector<std::string> files() override;
  int distantReads() const override { return array_->distantReads(); }
  // A chunk.
  ReadUnits readUnits() const override { return {.voxels = chunkVoxels()}; }
  uint64_t storedBytesRead() const override;
  std::optional<StoredReads> storedReads(int64_t time, std::span<const LevelBox> boxes,
                                         uint64_t held_bytes) override;

  // A chunk being decoded, its compressed bytes, and one being copied from; of the level with the
  // largest chunks.
  uint64_t heldBytesAThread() const override;
  // Limits the whole image, with its levels. Does nothing on a level of an image.
  void holdAtMost(uint64_t bytes) override;
  // For chunks that are stored as they are, in files of this machine: a pass waits for files then.
  PassReads passReads() const override;

  // Bytes of decoded chunks and of those being decoded, of all levels, without indices of shards,
  // now and at most so far.
  uint64_t heldBytes() const { return cache_->held().now(); }
  uint64_t peakHeldBytes() const { return cache_->held().peak(); }
  // The size of a chunk along x, y and z.
  Vec3i chunkVoxels() const;
  // The array itself, for code that wants its chunks as they are stored.
  ChunkedArray& chunks() { return *array_; }
  const ChunkedArray& chunks() const { return *array_; }

 private:
  // The volume itself, with levels if it is an image; or a level or spreads of that image.
  enum class Part { kImage, kLevel };

  ChunkedSource(const ChunkedVolume& volume, OpenedArray opened, size_t level,
                const ChannelWish& channel, std::shared_ptr<ZarrChunkCache> cache, Part part);
  // Opens the coarser levels of an image.
  void openLevels(const ChunkedVolume& volume);
  // A level or spreads of this image.
  std::unique_ptr<ChunkedSource> openPart(const ChunkedVolume& volume, OpenedArray opened,
                                          size_t level);
  // The spreads of a level; null if there are none, or, with a note, if they do not fit.
  std::unique_ptr<ChunkedSource> openSpreads(const ChunkedVolume& volume, size_t level,
                                             const VolumeLayout& layout);
  // The level of a group beside those of the image; null, with a note: it does not fit.
  std::unique_ptr<ChunkedSource> openInGroup(const ChunkedVolume& volume, size_t group,
                                             size_t level, const VolumeLayout& layout);
  // All sources that follow here.
  std::vector<ChunkedSource*> sourcesAbove() const;
  // Calls `visit` with the number of each chunk that a box needs.
  template <class Visit>
  void eachChunk(int64_t time, const Box3& box, const Visit& visit) const;
  // The reads of boxes of this level at a time step, with StoredReads::decodes for no memory. Sorts
  // the boxes.
  StoredReads storedReads(int64_t time, std::vector<Box3>& boxes);
  // Sets their placements, some of which their metadata leave open.
  void placeLevels(const ChunkedVolume& volume, const std::vector<size_t>& datasets);
  // Gives the levels of other kinds the places of those.
  void placeGroups();
  // The index of a voxel's chunk, or file, among parts of these extents.
  std::vector<int64_t> indexAt(std::span<const int64_t> parts, int64_t time, Vec3i at) const;
  // Their size along x, y and z.
  Vec3i voxelsOf(std::span<const int64_t> parts) const;
  // The voxels of a chunk, or the fill value if it is not there.
  ZarrChunkCache::Chunk load(int64_t chunk, ChunkMemory& memory);
  void copyChunk(std::span<const std::byte> chunk, int64_t time, const Box3& part, const Box3& box,
                 std::span<std::byte> out) const;
  // The same of one chunk for all regions that it is used for, or of the fill value.
  struct Use;
  void copyUses(std::span<const Use> uses, int64_t time, std::span<const std::byte> chunk) const;
  void fillUses(std::span<const Use> uses) const;

  ZarrView view_;        // constant after construction, as all that follows
  int64_t channel_ = 0;  // index along the axis view_.channel, if any
  std::string identity_;
  std::vector<std::string> channel_names_;
  std::vector<StoredLook> channel_looks_;
  std::vector<std::string> places_;  // see files()
  uint64_t header_bytes_ = 0;        // read of the metadata
  std::vector<std::byte> fill_;      // a voxel
  std::vector<double> blanked_;      // numbers that are read as NaN, see missing_values.h
  std::unique_ptr<ChunkedArray> array_;
  const std::shared_ptr<ZarrChunkCache> cache_;  // the image's
  const Part part_;
  int array_number_ = 0;  // in cache_
  std::vector<std::unique_ptr<ChunkedSource>> level_sources_;
  std::vector<std::unique_ptr<ChunkedSource>> spread_sources_;  // of each of these, or null
  std::unique_ptr<ChunkedSource> spreads_;                      // see spreads()
  std::vector<CoarserLevel> levels_above_;
  // Levels of other kinds.
  struct LevelGroup {
    LevelValues values = LevelValues::kUnknown;
    std::vector<std::unique_ptr<ChunkedSource>> sources;  // one for each of level_sources_, or null
    std::vector<CoarserLevel> levels;
  };
  std::vector<LevelGroup> level_groups_;
};

}  // namespace sluice
