// PieceVoxels: the voxels of a piece's mixed blocks, and one layer more for gradients, in device
// form. Blocks that the surface does not pass through are never read. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/surface/pieces.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {

// Mixed blocks side by side along x.
struct VoxelRun {
  Box3 blocks, cells;  // without the layer around a closed region
  Box3 voxels;         // x fastest
  std::byte* bytes = nullptr;
};

class PieceVoxels {
 public:
  // `source` must outlive it.
  explicit PieceVoxels(VolumeSource& source)
      : source_(source), reader_(source), type_(deviceMap(source.layout()).type) {}

  // Reads all of a piece; the runs hold until the next call. Throws Error from the source.
  void read(int64_t time, const PieceGrid& grid, const Piece& piece, const BlockStates& states);

  const std::vector<VoxelRun>& runs() const { return runs_; }
  DeviceType type() const { return type_; }
  // Bytes of stored voxels that the last piece took.
  uint64_t storedBytes() const;
  // Mixed blocks of the last piece.
  uint64_t blocks() const;

 private:
  VolumeSource& source_;
  DeviceReader reader_;
  const DeviceType type_;
  std::vector<VoxelRun> runs_;
  std::vector<std::byte> bytes_;
};

}  // namespace sluice
