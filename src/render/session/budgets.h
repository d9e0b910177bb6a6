// How --memory is shared out among the levels (design, point 3). Pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "cache/model/page_geometry.h"
#include "src/base/error.h"
#include "src/base/sources/volume_source.h"
#include "src/device/device.h"
#include "src/render/blocks/time_step.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

struct Budgets {
  uint64_t volume_buffer = 0, texture_cache = 0;
  uint64_t texture_buffer = 0;  // includes what a device borrows
  uint64_t borrowed = 0;        // the most of texture_buffer that a device borrows
  uint64_t scratch = 0;         // for the reading threads
  uint64_t source = 0;          // chunks that the source keeps decoded
  uint64_t boxes = 0;           // growing boxes
  uint64_t growing = 0;         // voxels that they are made of
  int readers = 1;              // threads that read and copy in addition to the one that draws
};

// Uses of memory besides the textures.
struct BufferNeeds {
  int64_t block_vox = 64;            // a side
  uint64_t source_thread_bytes = 0;  // VolumeSource::heldBytesAThread()
  uint64_t growing_bytes = 0;        // of a block (volume_boxes.h); 0: no growing boxes are drawn
  uint64_t beside_bytes = 0;         // that others hold of the same memory: min-max arrays
  int64_t numbers = 1;               // a voxel of the largest block: 2 with spreads
};
// The needs of a residency that serves all steps like this one, with all their levels.
BufferNeeds needsOf(const TimeStep& step, Partition partition, uint64_t beside_bytes);

// How many blocks are read at once for a program of so many threads: enough to keep a disk busy
// that serves many reads at once, on machines of few cores too, or a distant server.
int readsAtOnce(const VolumeSource& source, int threads);

// The least that levels 1 to 3 work with: two merged chunks; for one reader and the drawing thread
// two blocks each, their scratch, the source's memory for them and the voxels of their growing
// boxes; and the memory that others hold.
uint64_t leastBufferBytes(const PageGeometry& page, const BufferNeeds& needs);
// The part of --memory that level 4 takes: a device's copies and the storage that may wait for
// reuse; or the bytes that it borrows from level 3 and the tables that it makes of them
// (kTableBrickSide).
uint64_t textureMemoryBytes(const PageGeometry& page, TexelPlace texels);

// --memory holds less than the least that levels 1 to 3 and the textures work with.
class MemoryShortage : public Error {
 public:
  struct Bytes {
    uint64_t memory = 0;
    uint64_t textures = 0;  // or the chunks that a device borrows, with its tables of them
    uint64_t buffers = 0;
    TexelPlace texels = TexelPlace::kInMemory;
  };
  // `channels`: so many share --memory evenly, and the bytes are the part and the needs of one. The
  // message names `least_bytes` for all of them; unset: as much as these needs.
  explicit MemoryShortage(const Bytes& of_one, size_t channels = 1,
                          std::optional<uint64_t> least_bytes = {});
  const Bytes& ofOne() const { return of_one_; }

 private:
  Bytes of_one_;
};

// The least memory that holds what is needed of it. Some needs grow with the memory, such as those
// of plans of a cut, whose blocks may take half of it. `needOf`: the bytes that are needed of so
// much memory; they must never become less with more memory. Requires: needOf(refused) > refused.
uint64_t leastMemoryBytes(const std::function<uint64_t(uint64_t memory_bytes)>& needOf,
                          uint64_t refused);

// Up to `most_readers` readers, fewer if memory is short. Throws MemoryShortage when level 4 leaves
// too little to the others.
Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, TexelPlace texels,
                    const BufferNeeds& needs, int most_readers);

}  // namespace sluice
