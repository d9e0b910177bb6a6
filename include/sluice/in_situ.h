// Pictures in situ: the processes of an MPI program, its ranks, draw a volume together of which
// each has a box in memory already. Nothing of the voxels is sent from rank to rank, and nothing is
// copied but the blocks that pictures show, within each rank's memory_bytes.
//
//   sluice::Ranks ranks(MPI_Comm_c2f(MPI_COMM_WORLD));
//   const sluice::Volume volume = sluice::Volume::borrow(
//       array, {.dims = {512, 512, 512}, .type = "f32"}, {.lo = lo, .hi = hi, .ghosts_below =
//       ghosts, .ghosts_above = ghosts}, ranks);
//   sluice::Renderer renderer(volume, {.threshold = 0.5});
//   const sluice::Image image = renderer.draw();
//   if (ranks.rank() == 0) image.writePng("step.png");
//
// sluice is not linked to MPI: it opens a module of its own for Open MPI or MPICH, whichever the
// program is linked to.
#pragma once

#include <sluice/volume.h>

#include <array>
#include <cstdint>
#include <memory>

namespace sluice {

// The ranks of a communicator of yours. A handle: copies are the same ranks.
//
// All ranks must make these calls together, and in the same order: the constructor,
// Volume::borrow() with these ranks, the constructor of a Renderer of that volume, and its draw().
// Each runs on the
// thread that calls it, which must be the one that may call MPI. If one rank fails, all throw its
// Error.
class Ranks {
 public:
  // `fortran_communicator`: MPI_Comm_c2f(your_communicator), which is duplicated. MPI must have
  // been initialized, and must not be finalized before the last volume of these ranks is closed.
  // Throws Error: no module for this MPI.
  explicit Ranks(int fortran_communicator);

  int rank() const;
  int count() const;

  struct Impl;
  explicit Ranks(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

 private:
  friend class Volume;
  std::shared_ptr<Impl> impl_;
};

// A rank's part of a volume. The boxes of all ranks must tile it, so that planes along the axes
// part them again and again, as grids, slabs and recursive bisections do.
struct LentBox {
  std::array<int64_t, 3> lo = {}, hi = {};  // voxels of the volume, `hi` not included
  // Layers of further voxels that the array has below `lo` and above `hi - 1`, which other ranks
  // have in their boxes. Inside the volume, pictures need one above, and lit ones one below and two
  // above.
  std::array<int64_t, 3> ghosts_below = {}, ghosts_above = {};
};

}  // namespace sluice
