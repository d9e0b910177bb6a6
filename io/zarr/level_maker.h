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
#include <optional>
#include <span>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/values/vec.h"
#include "src/base/values/volume_levels.h"
#include "src/base/values/volume_source.h"

namespace sluice {

// The value of a coarse voxel, from its block of finer ones. NaN counts only if a block has nothing
// else. If several values are most frequent, kMode takes the least.
enum class Downsample { kMean, kMax, kMode };
// Whether the levels have spreads.
constexpr bool keepsSpreads(Downsample how) {
  return how == Downsample::kMean;
}
// "mean", "max", "mode".
const char* nameOf(Downsample how);

struct LevelShape {
  Vec3i dims;  // voxels
  Vec3i step;  // finest voxels of one along each axis, powers of two
};
LevelPlacement placementOf(const LevelShape& shape);

// The coarser levels of a volume for chunks of `chunk_voxels` a side, from fine to coarse: each
// halves the axes whose voxels are short, so that voxels get closer to cubes. `most`: that many;
// without, until the longest side has at most kCoarsestSide voxels. Ends if a voxel would stand for
// more than a chunk's side, or if no axis can be halved. Requires: chunk_voxels > 0.
std::vector<LevelShape> levelShapes(const VolumeLayout& layout, int64_t chunk_voxels,
                                    std::optional<int64_t> most);
inline constexpr int64_t kCoarsestSide = 64;

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

  // Takes the voxels of a cube, x fastest with these strides in voxels. Any thread may call it, for
  // cubes that do not overlap. Requires: box.lo is a multiple of chunk_voxels, box.hi too or the
  // volume's end.
  void add(const Box3& box, const std::byte* voxels, int64_t row_stride, int64_t plane_stride);

  // The layer of a level's chunks in which the finest plane `z` lies; in voxels of the level.
  Box3 layerAt(size_t level, int64_t z) const;
  // Its voxels, x fastest, packed, once all its cubes have come.
  const std::byte* layerVoxels(size_t level) const { return layers_[level].data(); }
  // Their spreads, in the same order. Requires: keepsSpreads().
  const std::byte* layerSpreads(size_t level) const { return spreads_[level].data(); }
  // Begins with the next layer: all fill again, without a spread.
  void clearLayer(size_t level);

 private:
  template <class T>
  void addOf(const Box3& box, const T* voxels, int64_t row_stride, int64_t plane_stride);

  const Vec3i dims_;
  const VoxelType type_;
  const int64_t chunk_voxels_;
  const std::vector<LevelShape> levels_;
  const Downsample how_;
  const std::vector<std::byte> fill_;
  std::vector<std::vector<std::byte>> layers_, spreads_;
  // Passed on from cube to cube: fresh memory costs as much as the work done in it.
  struct Scratch;
  Mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> idle_ SLUICE_GUARDED_BY(mutex_);
};

// The voxels of a box of one level of means, and their spreads, made of the finest voxels alone:
// for a level that cannot be read. Reads level.step times as many voxels along each axis, a cube of
// 64 at a time at the most. `voxels` and `spreads` are packed, x fastest; one of them may be empty,
// and is then not filled. Throws Error from the source. Requires: the box is inside the level.
void makeLevelRegion(VolumeSource& finest, int64_t time, const LevelShape& level, const Box3& box,
                     std::span<std::byte> voxels, std::span<std::byte> spreads);

}  // namespace sluice
