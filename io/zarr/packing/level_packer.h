// LevelPacker: makes the coarser levels of a volume from voxels that pass once (level_maker.h), and
// packs them, and their spreads if they have some, as arrays of an unfinished store.
//
// The store's arrays for it are one a level, from fine to coarse, and then one a level for the
// spreads. Voxels come in layers of `chunk_voxels` planes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/zarr/levels/level_maker.h"
#include "io/zarr/packing/chunk_packer.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

// The arrays of a store for the levels of a volume whose finest array is `finest`, from fine to
// coarse, then those of their spreads. Folders are counted from `first` on: "1", "spread/1"; in
// the group `group`, if it is not empty: "maximum/1".
std::vector<PackedArray> levelArrays(const ZarrArray& finest, std::span<const LevelShape> levels,
                                     Downsample how, int64_t first, std::string_view group = {});

class LevelPacker {
 public:
  // `first`: the levels' first array in the folder. `packer` and `pool` must outlive it. Holds
  // LevelMaker::pendingBytes().
  LevelPacker(const VolumeLayout& layout, int64_t chunk_voxels, std::vector<LevelShape> levels,
              Downsample how, std::span<const std::byte> fill, size_t first, ChunkPacker& packer,
              WorkerPool& pool);

  const std::vector<LevelShape>& levels() const { return maker_.levels(); }
  // `leading`, here and below: the index of the time step and channel along the arrays' first axes.
  // Whether a level still lacks chunks of the layer in which the finest plane `z` lies.
  bool isLayerWanted(const ZarrPackFolder& folder, std::span<const int64_t> leading,
                     int64_t z) const;
  // See LevelMaker.
  int64_t longestRow() const { return maker_.longestRow(); }
  void add(const Box3& box, const std::byte* voxels, int64_t row_stride, int64_t plane_stride) {
    maker_.add(box, voxels, row_stride, plane_stride);
  }
  // Writes the layers of chunks that end with the finest planes before `end`, and begins the next.
  // Throws Error, Interrupted.
  void packLayers(ZarrPackFolder& folder, std::span<const int64_t> leading, int64_t end,
                  const StopToken& stop);

 private:
  // The folder's arrays, counted from the first level's, and the level that each is of.
  size_t arrays() const { return levels().size() * (has_spreads_ ? 2 : 1); }
  size_t levelOf(size_t array) const { return array % levels().size(); }
  bool isSpreads(size_t array) const { return array >= levels().size(); }
  // Places of the chunks of an array's layer that are not done.
  std::vector<Vec3i> missingOf(const ZarrPackFolder& folder, size_t array,
                               std::span<const int64_t> leading, const Box3& layer) const;

  const int64_t planes_, chunk_voxels_;
  const bool has_spreads_;
  const size_t first_;
  ChunkPacker& packer_;
  WorkerPool& pool_;
  LevelMaker maker_;
};

}  // namespace sluice
