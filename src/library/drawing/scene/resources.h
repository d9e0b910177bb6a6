// The resources for a picture on this machine: the budget, the texture pages, the session. Pure
// functions.
#pragma once

#include <cstdint>
#include <string>

#include "src/library/drawing/cost/picture_memory.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/requests.h"
#include "src/render/session/session.h"

namespace sluice {

// The default of MachineOptions::memory_bytes: half of what the machine or its cgroup has.
uint64_t memoryBudget(const MachineOptions& machine);

// Whether a picture is drawn alone, or others of the same volume follow it.
enum class PictureRow { kOne, kMore };
// The bytes of voxels that a picture of several levels of resolution may have. In a row they stay
// in memory from one frame to the next, and leave the volume buffer room for the coarser blocks of
// pictures that are drawn while a view moves.
constexpr uint64_t cutBytes(uint64_t memory_bytes, PictureRow row) {
  return row == PictureRow::kOne ? memory_bytes / 2 : memory_bytes / 8 * 3;
}

// The standard 64 KiB page of the voxel type unless the user sets another; the number of pages is
// still open.
PageGeometry pageShape(const MachineOptions& machine, const ValueMap& map);
// The machine for a volume that is drawn with the first one: unless the user says how large blocks
// are, two on the same grid have the blocks of the first one, so that they can be blended.
MachineOptions withBlocksOfFirst(MachineOptions machine, const VolumeLayout& own,
                                 const VolumeLayout& first);
// The line about blocks that are so small that a picture may take far more memory for them than for
// the voxels; empty: they are not.
std::string smallBlocksNote(const IndexedVolume& volume);
// How many pages, of what `beside_bytes` (min-max arrays and others) leave of the memory: as the
// user says, or what holds the volume, or what memory comfortably does beside the least buffers.
int64_t pageCount(const MachineOptions& machine, const IndexedVolume& volume,
                  uint64_t beside_bytes);

// The bytes that plans of frames with this look take in addition to the levels: for each block
// that is planned
// its boxes, its chunk and their names, its places in the order of the visit and in the tables of
// all levels. A series has the next step's plan, too. The spreads that are noted of coarse blocks
// (spread_tally.h), and the ranges that are learnt of finest ones (learnt_ranges.h), are counted
// with them. Classifies the step that the volume was
// opened for.
uint64_t planBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                   const FrameOptions& frame, WorkerPool& pool);

// The widest picture for which enoughToDraw() is enough: wider ones have larger strips.
inline constexpr int kEnoughSide = 4096;
// The memory with which a picture of a channel and of those that are drawn with it is drawn,
// whatever it shows, if the channel's min-max arrays take `array_bytes` at all levels together. For
// a volume that is not indexed yet. `has_levels`: it has several or gets them.
uint64_t enoughToDraw(const IndexedVolume& volume, const IndexPass& pass, bool has_levels,
                      uint64_t array_bytes);

// The size of the blocks in which a picture is drawn again to compare it: other blocks have other
// borders, so that a fault there shows as a difference.
constexpr int64_t comparedBlock(int64_t block) {
  return block > 16 ? block / 2 : block * 2;
}
// The bytes that a volume in such blocks takes beyond those that it takes in its own.
uint64_t comparingBytes(const IndexedVolume& volume);

// The bytes held in addition to the levels, and the pages of the texture cache that they leave room
// for.
struct BesideShare {
  uint64_t picture_bytes = 0, beside_bytes = 0;
  int64_t pages = 0;
};
// `others_bytes`: min-max arrays and whatever else is held. The picture gets a quarter of the
// memory if the levels then have the least that they work with, otherwise the least strip.
BesideShare besideShare(const IndexedVolume& volume, const MachineOptions& machine,
                        Partition partition, const PictureDemand& picture, uint64_t others_bytes);
// `lit`: frames may be shaded, the volume was indexed with gradients.
SessionOptions sessionOptions(const IndexedVolume& volume, bool lit, const MachineOptions& machine,
                              Partition partition, uint64_t memory_bytes);

}  // namespace sluice
