// Pictures of a volume of which each rank of an MPI program has a part, as a simulation has:
//   mpirun -n 4 in_situ FILE.raw NX NY NZ THRESHOLD PICTURE.png
// FILE has NX x NY x NZ voxels of a byte. Each rank reads a slab of it with its ghosts and lends
// that; the picture is drawn by all and written by the first.
#include <mpi.h>
#include <sluice/in_situ.h>
#include <sluice/renderer.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Slab {
  sluice::LentBox box;
  std::vector<char> voxels;
};

// The layers of z that are the rank's, with one layer of ghosts below and two above.
Slab readSlab(const std::string& file, const std::array<int64_t, 3>& dims, int rank, int ranks) {
  Slab slab;
  const int64_t first = dims[2] * rank / ranks, last = dims[2] * (rank + 1) / ranks;
  slab.box = {.lo = {0, 0, first}, .hi = {dims[0], dims[1], last}};
  slab.box.ghosts_below[2] = std::min<int64_t>(first, 1);
  slab.box.ghosts_above[2] = std::min<int64_t>(dims[2] - last, 2);
  const int64_t layer = dims[0] * dims[1];
  const int64_t from = first - slab.box.ghosts_below[2], to = last + slab.box.ghosts_above[2];
  slab.voxels.resize(static_cast<size_t>(layer * (to - from)));
  std::ifstream in(file, std::ios::binary);
  in.seekg(layer * from);
  if (!in.read(slab.voxels.data(), static_cast<std::streamsize>(slab.voxels.size())))
    throw std::runtime_error(file + ": cannot be read, or has too few voxels");
  return slab;
}

void run(char** words) {
  const std::array<int64_t, 3> dims{std::atoll(words[2]), std::atoll(words[3]),
                                    std::atoll(words[4])};
  const sluice::Ranks ranks(MPI_Comm_c2f(MPI_COMM_WORLD));
  const Slab slab = readSlab(words[1], dims, ranks.rank(), ranks.count());
  const sluice::Volume volume = sluice::Volume::borrow(
      slab.voxels.data(), {.dims = dims, .type = "u8", .name = words[1]}, slab.box, ranks);
  sluice::RendererOptions machine;
  machine.device = sluice::RendererOptions::Device::kCpu;
  sluice::Renderer renderer(volume, {.threshold = std::atof(words[5])}, machine);
  const sluice::Image picture = renderer.draw();
  if (ranks.rank() == 0) picture.writePng(words[6]);
}

}  // namespace

int main(int count, char** words) {
  MPI_Init(&count, &words);
  int status = 0;
  if (count != 7) {
    std::cerr << "usage: in_situ FILE.raw NX NY NZ THRESHOLD PICTURE.png\n";
    status = 2;
  } else {
    try {
      run(words);
    } catch (const sluice::Error& error) {
      // All ranks have the same line.
      int rank = 0;
      MPI_Comm_rank(MPI_COMM_WORLD, &rank);
      if (rank == 0) std::cerr << "in_situ: " << error.what() << "\n";
      status = 1;
    } catch (const std::exception& error) {
      // The others may wait for this rank.
      std::cerr << "in_situ: " << error.what() << "\n";
      MPI_Abort(MPI_COMM_WORLD, 1);
    }
  }
  MPI_Finalize();
  return status;
}
