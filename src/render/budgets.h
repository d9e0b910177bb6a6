// How --memory is shared out among the levels (design, point 3). Pure functions.
#pragma once

#include <cstdint>

#include "cache/model/page_geometry.h"
#include "src/base/volume_source.h"
#include "src/device/device.h"
#include "src/render/frame_options.h"
#include "src/volume/block_layout.h"

namespace sluice {

struct Budgets {
  uint64_t volume_buffer = 0, texture_cache = 0;
  uint64_t texture_buffer = 0;  // what a device borrows included
  uint64_t borrowed = 0;        // of it, at most
  uint64_t scratch = 0;         // of the threads that read
  uint64_t source = 0;          // of chunks that the source holds decoded
  uint64_t boxes = 0;           // growing boxes
  uint64_t growing = 0;         // voxels that they are made of
  int readers = 1;              // threads that read and copy beside the one that draws
};

// What takes memory beside the textures.
struct BufferNeeds {
  int64_t block_vox = 64;            // a side
  uint64_t source_thread_bytes = 0;  // VolumeSource::heldBytesAThread()
  uint64_t growing_bytes = 0;        // of a block (volume_boxes.h); 0: no growing boxes are drawn
  uint64_t beside_bytes = 0;         // that others hold of the same memory: min-max arrays
  int64_t numbers = 1;               // a voxel of the largest block: 2 with spreads
};
BufferNeeds bufferNeeds(const VolumeSource& source, const BlockLayout& layout, Partition partition,
                        uint64_t beside_bytes);

// The least that levels 1 to 3 work with: two merged chunks, and for one reader and the thread that
// draws two blocks each, their scratch, what the source holds for them and what they grow boxes of;
// and what others hold.
uint64_t leastBufferBytes(const PageGeometry& page, const BufferNeeds& needs);
// What level 4 takes of --memory: a device's copies and the storage that may wait beside them, or
// what it borrows of level 3 and the tables that it makes of that (kTableBrickSide).
uint64_t textureMemoryBytes(const PageGeometry& page, TexelPlace texels);

// Up to `most_readers` readers, fewer where memory is short. Throws Error, with the least that
// works, when level 4 leaves too little to the others.
Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, TexelPlace texels,
                    const BufferNeeds& needs, int most_readers);

}  // namespace sluice
