// RawSource: a VolumeSource over voxels that lie in files one after the other, x fastest.
//
// Every format that is "a header, then the voxels" is one of these once its header is read: raw,
// NRRD, MetaImage and NIfTI. The voxels of all time steps are one sequence, shared out evenly over
// one or more segments (slices or slabs in files of their own). A box is gathered with as few
// system calls as its layout allows: pieces that lie close together in a segment become one read,
// gaps included (and counted), out of which they are copied. Nothing is cached.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/files/byte_store.h"
#include "src/base/memory/aligned_array.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/mutex.h"

namespace sluice {

// The place of an even share of the voxels.
struct RawSegment {
  std::shared_ptr<ByteStore> store;
  uint64_t offset_bytes = 0;
};

class RawSource : public VolumeSource, public UnitSource {
 public:
  // `header`, if it is a file of its own and not null, is counted with the bytes read. The voxels
  // are in `byte_order`. Requires: the layout's bytes do not overflow, and the number of segments
  // divides the number of voxels; their sizes were checked.
  RawSource(VolumeLayout layout, std::endian byte_order, std::vector<RawSegment> segments,
            std::shared_ptr<const ByteStore> header, std::string identity);

  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  // Regions of equal y and z extents are read row by row across all of them.
  void readRegions(int64_t time, std::span<const RegionRead> regions) override;
  // Tells the store of boxes of nearly whole rows: all of a file's pages there are wanted.
  void expectRegion(int64_t time, const Box3& box) override;
  std::string identity() const override { return identity_; }
  std::vector<std::string> files() override;
  ReadUnits readUnits() const override;
  uint64_t heldBytesAThread() const override;
  // Shares the bytes out among the segments.
  void holdAtMost(uint64_t bytes) override;
  uint64_t storedBytesRead() const override;

 private:
  class Gather;
  // Adds `voxels` voxels from `first` (in the sequence of all) on.
  void addPiece(Gather& gather, int64_t first, int64_t voxels, std::byte* to) const;
  // Whether the store should be told of a box before it is read.
  bool isExpected(const Box3& box) const;
  // Tells the store of the rows of a box, whole, plane by plane: a disk serves many places at once
  // faster than one after the other.
  void expectPlanes(int64_t time, const Box3& box) const;

  const VolumeLayout layout_;
  const bool swapped_;
  const std::vector<RawSegment> segments_;
  const int64_t segment_voxels_;
  const std::shared_ptr<const ByteStore> header_;
  const std::string identity_;
  // Gathers take their room from here and give it back: there are as many as threads read at a
  // time. The allocator would map a room anew for each read, and each of its pages would be a
  // fault.
  Mutex spans_mutex_;
  std::vector<AlignedArray<std::byte>> idle_spans_ SLUICE_GUARDED_BY(spans_mutex_);
};

}  // namespace sluice
