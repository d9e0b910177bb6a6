// ChunkPacker: cuts chunks out of voxels in memory, encodes them and hands them to the folder of an
// unfinished store. Any number of threads may pack at once; each holds scratch for one chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/zarr/packing/zarr_pack_folder.h"
#include "io/zarr/reading/zarr_codec.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/mutex.h"

namespace sluice {

// An array that sluice packs, of a volume's voxels in chunks of `chunk_voxels` a side. `leading`:
// its shape along the axes before z.
ZarrArray packedArray(const VolumeLayout& layout, std::span<const int64_t> leading,
                      int64_t chunk_voxels, double fill_value);
// A voxel of the array's fill value.
std::vector<std::byte> fillVoxel(const ZarrArray& array);

// A box of voxels in memory, x fastest, packed.
struct HeldVoxels {
  Box3 box;
  const std::byte* voxels;
};

class ChunkPacker {
  struct Scratch {
    int number = 0;
    std::vector<std::byte> chunk, stored;
  };

 public:
  // `arrays` of the store, in the folder's order, with chunks of `chunk_voxels` a side along x, y
  // and z; they must outlive it. Requires: no array has larger chunks, in bytes, than the first.
  ChunkPacker(std::span<const PackedArray> arrays, int64_t chunk_voxels, const BloscOptions& blosc);

  // The memory of a thread: a chunk, its file, and as much again inside Blosc.
  static uint64_t threadBytes(uint64_t chunk_bytes) {
    return 2 * chunk_bytes + bloscRoomBytes(chunk_bytes);
  }

  // The places of the chunks that a box reaches into, and the voxels of such a chunk.
  std::vector<Vec3i> chunksOf(const Box3& box) const;
  Box3 boxOf(Vec3i chunk) const;
  // The number of an array's chunk in the folder. `leading`: its index along the axes before z.
  int64_t numberOf(const ZarrPackFolder& folder, size_t array, std::span<const int64_t> leading,
                   Vec3i chunk) const;

  // Packs the chunk at a place of an array; voxels that are not held are fill value.
  void pack(ZarrPackFolder& folder, size_t array, int64_t number, const HeldVoxels& held,
            Vec3i chunk);
  // Notes that a chunk is all fill value.
  void packEmpty(ZarrPackFolder& folder, int64_t number);

  // Scratch of one thread for the time of one chunk. At most as many are made as threads.
  class Lease {
   public:
    explicit Lease(ChunkPacker& packer);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Scratch* operator->() const { return scratch_.get(); }

   private:
    ChunkPacker& packer_;
    std::unique_ptr<Scratch> scratch_;
  };

 private:
  const std::span<const PackedArray> arrays_;
  const int64_t chunk_voxels_;
  const BloscOptions blosc_;
  std::vector<std::vector<std::byte>> fills_;  // a voxel of each array
  Mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> idle_ SLUICE_GUARDED_BY(mutex_);
  int made_ SLUICE_GUARDED_BY(mutex_) = 0;
};

}  // namespace sluice
