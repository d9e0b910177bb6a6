// OME-Zarr images and plain Zarr arrays, of version 2 and 3, as a VolumeSource.
//
// A folder with a .zarray or an array's zarr.json is an array; one whose .zattrs or zarr.json has
// `multiscales` is an image: level 0 is
// the volume, the others are its coarser levels, as far as their arrays are there and fit what is
// said of them (io/zarr/reading/zarr_levels.h); a note names each that is left out. Levels that
// sluice packed as means have their spreads (io/zarr/metadata/zarr_image.h). Name the folder of a
// level to read that one alone; its scale is found in the image around it. Axes, spacing and origin
// as io/zarr/metadata/zarr_image.h says, chunks as io/zarr/metadata/zarr_array.h.
//
// - Missing chunks are the fill value, and known as such: occupancy() has the boxes of the others.
//   Chunks that sluice packed carry checksums; then a missing or changed one is an Error.
// - A few decoded chunks are kept (io/zarr/reading/zarr_chunk_cache.h), as neighbouring blocks
// share them.
//   All levels of an image and their spreads share one limit, which is the image's: levels are not
//   used evenly, so that parts of it would be too small for one and idle for another.
// - identity() covers .zarray, .zattrs, checksums and the array's folder, and of a store without
//   checksums the status of at most kSampledChunks chunk files, evenly spread: there may be
//   millions.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "io/files/channel_choice.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "io/zarr/metadata/zarr_image.h"
#include "io/zarr/reading/zarr_chunk_cache.h"
#include "io/zarr/reading/zarr_chunk_files.h"
#include "src/base/values/read_units.h"
#include "src/base/values/volume_channels.h"
#include "src/base/values/volume_levels.h"
#include "src/base/values/volume_source.h"

namespace sluice {

// At 64^3 bytes each, they are a gigabyte.
inline constexpr int64_t kSampledChunks = 4096;

struct ZarrOptions {
  ChannelWish channel = {};
  // Limit for decoded chunks; the least that ZarrChunkCache holds is held even if it is more.
  uint64_t chunk_cache_bytes = uint64_t{32} << 20;
};

class ZarrSource final : public VolumeSource,
                         public ChanneledSource,
                         public LeveledSource,
                         public UnitSource {
 public:
  // Throws Error: nothing in the folder that can be read, --channel without such an axis.
  explicit ZarrSource(const StorePlace& folder, const ZarrOptions& options = {});
  explicit ZarrSource(const std::filesystem::path& folder, const ZarrOptions& options = {});
  ~ZarrSource() override;

  const VolumeLayout& layout() const override { return view_.layout; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  // nullopt when no chunk is missing. The background may be NaN or infinite.
  std::optional<Occupancy> occupancy(int64_t time) override;
  std::string identity() const override { return identity_; }
  std::span<const std::string> channelNames() const override { return channel_names_; }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_above_; }
  // Spreads of the first level's own voxels, which a group of the coarser levels of another volume
  // has (io/zarr/packing/level_store.h); null: none.
  VolumeSource* spreads() const { return spreads_.get(); }
  std::vector<std::string> files() override;
  int distantReads() const override { return files_->distantReads(); }
  // A chunk.
  ReadUnits readUnits() const override { return {.voxels = chunkVoxels()}; }
  uint64_t storedBytesRead() const override;

  // A chunk being decoded, its compressed bytes, and one being copied from; of the level with the
  // largest chunks.
  uint64_t heldBytesAThread() const override;
  // Limits the whole image, with its levels. Does nothing on a level of an image.
  void holdAtMost(uint64_t bytes) override;

  // Bytes of decoded chunks and of those being decoded, of all levels, without indices of shards,
  // now and at most so far.
  uint64_t heldBytes() const { return cache_->held().now(); }
  uint64_t peakHeldBytes() const { return cache_->held().peak(); }
  // The size of a chunk along x, y and z.
  Vec3i chunkVoxels() const;
  // Whether each chunk is checked as it is read.
  bool hasChecksums() const { return files_->hasChecksums(); }
  // The chunk files, for code that wants them as they are stored.
  ZarrChunkFiles& chunkFiles() { return *files_; }

 private:
  // A folder's own array, with levels if it is an image's; or a level or spreads of that image.
  enum class Part { kImage, kLevel };

  ZarrSource(const StorePlace& folder, FoundZarr found, const ChannelWish& channel,
             std::shared_ptr<ZarrChunkCache> cache, Part part);
  // Opens the coarser levels of an image.
  void openLevels(const StorePlace& folder, const FoundZarr& found);
  // A level or spreads of this image.
  std::unique_ptr<ZarrSource> openPart(const StorePlace& folder, FoundZarr found);
  // The spreads of a level, which its dataset says to have; null, and a note, if they do not fit.
  std::unique_ptr<ZarrSource> openSpreads(const StorePlace& folder, const FoundZarr& found,
                                          size_t dataset, const VolumeLayout& level);
  // level_sources_, spread_sources_ and spreads_.
  std::vector<ZarrSource*> sourcesAbove() const;
  // Sets their placements, some of which their metadata leave open.
  void placeLevels(const std::string& path, const FoundZarr& found,
                   const std::vector<size_t>& datasets);
  // The index of a voxel's chunk, or file, among parts of these extents.
  std::vector<int64_t> indexAt(std::span<const int64_t> parts, int64_t time, Vec3i at) const;
  // Their size along x, y and z.
  Vec3i voxelsOf(std::span<const int64_t> parts) const;
  // A chunk that is not there.
  ZarrChunkCache::Chunk filledChunk(ChunkMemory& memory) const;
  ZarrChunkCache::Chunk decode(int64_t chunk, ChunkMemory& memory);
  void copyChunk(std::span<const std::byte> chunk, int64_t time, const Box3& part, const Box3& box,
                 std::span<std::byte> out) const;

  ZarrView view_;        // constant after construction, as all that follows
  int64_t channel_ = 0;  // index along the axis view_.channel, if any
  std::string identity_;
  std::vector<std::string> channel_names_;
  std::vector<std::string> places_;  // see files()
  uint64_t header_bytes_ = 0;        // read of .zarray and .zattrs
  std::vector<std::byte> fill_;      // a voxel
  std::unique_ptr<ZarrChunkFiles> files_;
  const std::shared_ptr<ZarrChunkCache> cache_;  // the image's
  const Part part_;
  int array_number_ = 0;  // in cache_
  std::vector<std::unique_ptr<ZarrSource>> level_sources_;
  std::vector<std::unique_ptr<ZarrSource>> spread_sources_;  // of each of these, or null
  std::unique_ptr<ZarrSource> spreads_;                      // see spreads()
  std::vector<CoarserLevel> levels_above_;
};

}  // namespace sluice
