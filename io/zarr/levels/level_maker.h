// LevelMaker: the coarser levels of a volume, made of its voxels as they pass in cubes, once.
//
// A voxel of a level stands for a block of finest voxels, a power of two of them along each axis.
// It is made of those voxels themselves, not of the next finer level's, and rounded once. A cube
// has whole blocks of every level, so that cubes come in any order and on any thread as long as
// they are of one layer; of each level one layer of chunks is held until its last cube has come.
//
// Levels of means may have spreads too (volume_levels.h): a number of type spreadType() for each
// voxel of a level, twice the standard deviation of the finest voxels that it stands for, rounded
// once; 0 if it stands for a value that is not finite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/zarr/levels/level_shape.h"
#include "src/base/memory/aligned_array.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/mutex.h"
#include "src/base/values/vec.h"

namespace sluice {

class LevelMaker {
 public:
  // `fill`: a voxel, the value of everything that no cube comes for. Holds pendingBytes().
  // Requires: steps divide `chunk_voxels`.
  LevelMaker(const VolumeLayout& layout, int64_t chunk_voxels, std::vector<LevelShape> levels,
             Downsample how, std::span<const std::byte> fill);
  ~LevelMaker();

  // Bytes that the maker holds, and bytes that a thread takes inside add().
  static uint64_t pendingBytes(const VolumeLayout& layout, int64_t chunk_voxels,
                               std::span<const LevelShape> levels, Downsample how);
  static uint64_t threadBytes(const VolumeLayout& layout, int64_t chunk_voxels);

  const std::vector<LevelShape>& levels() const { return levels_; }
  // The voxels along x of the longest row of cubes that add() may take as one within threadBytes(),
  // a multiple of chunk_voxels. Long rows are faster. Sums of wide voxels are rounded and would
  // depend on the length, so that theirs are cubes.
  int64_t longestRow() const;

  // Takes the voxels of a cube, or of a row of cubes along x, x fastest with these strides in
  // voxels. Any thread may call it, for cubes that do not overlap. Requires: box.lo is a multiple
  // of chunk_voxels, box.hi too or the volume's end; at most chunk_voxels planes.
  void add(const Box3& box, const std::byte* voxels, int64_t row_stride, int64_t plane_stride);

  // The layer of a level's chunks in which the finest plane `z` lies; in voxels of the level.
  Box3 layerAt(size_t level, int64_t z) const;
  // To be called when all cubes of a layer have come: the places of others are fill, without a
  // spread, and the next cubes begin the next layer.
  void endLayer(size_t level);
  // The voxels of the layer that has ended, x fastest, packed.
  const std::byte* layerVoxels(size_t level) const { return layers_[level].voxels; }
  // Their spreads, in the same order. Requires: keepsSpreads().
  const std::byte* layerSpreads(size_t level) const { return layers_[level].spreads; }

 private:
  struct Layer {
    std::byte* voxels = nullptr;   // in room_
    std::byte* spreads = nullptr;  // the same; null: no spreads are kept
    std::vector<char> came;        // for each cube of the layer, x fastest
  };

  template <class T>
  void addOf(const Box3& box, const T* voxels, int64_t row_stride, int64_t plane_stride);
  // The cubes along each axis of a layer of the level.
  Vec3i cubesOf(size_t level) const;
  void fillPlaceOf(size_t level, Vec3i cube);

  const Vec3i dims_;
  const VoxelType type_;
  const int64_t chunk_voxels_;
  const std::vector<LevelShape> levels_;
  const Downsample how_;
  const std::vector<std::byte> fill_;
  // The voxels and spreads of all layers, not set to anything before their cubes come. Large pages:
  // they are filled once, and read in short rows that lie far apart.
  AlignedArray<std::byte> room_;
  std::vector<Layer> layers_;  // of each level; threads write to places of their own
  // Passed on from cube to cube: fresh memory costs as much as the work done in it.
  struct Scratch;
  Mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> idle_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
