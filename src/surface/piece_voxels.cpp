#include "src/surface/piece_voxels.h"

namespace sluice {

void PieceVoxels::read(int64_t time, const PieceGrid& grid, const Piece& piece,
                       const BlockStates& states) {
  const BlockLayout& layout = grid.layout();
  runs_.clear();
  for (int64_t x = piece.blocks.lo.x; x < piece.blocks.hi.x; ++x) {
    const Vec3i index{x, piece.blocks.lo.y, piece.blocks.lo.z};
    const Box3 cells = intersect(layout.ownedCells(index), grid.region().cells);
    if (cells.empty() || states.stateOf(layout.idOf(index)) != RangeState::kMixed) continue;
    // Neighbouring mixed blocks are read as one region: their shared layer of voxels is read once.
    const Box3 block{index, index + Vec3i{1, 1, 1}};
    if (!runs_.empty() && runs_.back().blocks.hi.x == x) {
      runs_.back().blocks = unite(runs_.back().blocks, block);
      runs_.back().cells = unite(runs_.back().cells, cells);
    } else {
      runs_.push_back({block, cells, {}, nullptr});
    }
  }
  constexpr size_t kAlignment = 64;
  size_t bytes = 0;
  std::vector<size_t> begins;
  for (VoxelRun& run : runs_) {
    // Gradients by central differences need one voxel more on either side than the cells' corners.
    run.voxels = intersect({run.cells.lo - Vec3i{1, 1, 1}, run.cells.hi + Vec3i{2, 2, 2}},
                           boxOf(layout.dims));
    begins.push_back(bytes);
    const size_t taken = static_cast<size_t>(run.voxels.count()) * bytesPerVoxel(type_);
    bytes += (taken + kAlignment - 1) / kAlignment * kAlignment;
  }
  if (bytes_.size() < bytes) {
    bytes_.clear();  // never two at once
    bytes_.shrink_to_fit();
    bytes_.resize(bytes);
  }
  std::vector<RegionRead> regions;
  for (size_t i = 0; i < runs_.size(); ++i) {
    VoxelRun& run = runs_[i];
    run.bytes = bytes_.data() + begins[i];
    regions.push_back(
        {run.voxels, {run.bytes, static_cast<size_t>(run.voxels.count()) * bytesPerVoxel(type_)}});
  }
  reader_.read(time, regions);
}

uint64_t PieceVoxels::storedBytes() const {
  uint64_t voxels = 0;
  for (const VoxelRun& run : runs_) voxels += static_cast<uint64_t>(run.voxels.count());
  return voxels * bytesPerVoxel(source_.layout().type);
}

uint64_t PieceVoxels::blocks() const {
  int64_t count = 0;
  for (const VoxelRun& run : runs_) count += run.blocks.count();
  return static_cast<uint64_t>(count);
}

}  // namespace sluice
