// makeSurface: the surface of the voxels of at least a value, as a mesh of triangles, in bounded
// memory. Read this header first.
//
//   min-max arrays -> blocks that the surface passes through   (block_states.h)
//   blocks         -> pieces, rows of blocks along x           (pieces.h)
//   for each piece, on all threads:
//     mixed blocks -> voxels in device form                    (piece_voxels.h)
//     voxels       -> a bit for each one that is inside        (corner_bits.h)
//     bits         -> numbers of the vertices, in order        (vertex_numbers.h)
//     all of these -> vertices and triangles                   (piece_mesher.h, vertex_maker.h,
//                                                               cell_table.h)
//   parts          -> the file, in order                       (ordered_parts.h, io/meshes)
//
// A voxel is inside if its value is at least the threshold, as `--threshold` shows it; NaN is not.
// Triangles are seen counterclockwise from outside, where the values are lower, and normals point
// there. Each vertex belongs to one edge between two voxels and is made once, also on the faces
// between blocks: every side of a triangle is shared by exactly two, except along the border of the
// region of an open surface. The mesh depends on neither the threads nor the memory nor the size of
// blocks, except for the order of its vertices and triangles, which the last two may change.
#pragma once

#include <cstdint>
#include <functional>

#include "io/meshes/mesh_file.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/surface/block_states.h"
#include "src/surface/inside_set.h"
#include "src/surface/pieces.h"
#include "src/surface/surface_place.h"

namespace sluice {

// Called with the least and greatest device value of a block's own voxels when it was read whole;
// the Error that it throws ends the work. On any thread, on several at once.
using CheckBlock = std::function<void(int64_t block, double lo, double hi)>;

struct SurfaceRequest {
  VolumeSource& source;  // of the level
  int64_t time = 0;
  InsideSet inside;
  SurfacePlace place;
  SurfaceRegion region;
  BlockStates states;  // of the level's blocks
  CheckBlock check;    // may be null
  uint64_t memory_bytes = UINT64_MAX;
  StopToken stop = {};
};

struct SurfaceReport {
  uint64_t vertices = 0, triangles = 0;
  int64_t blocks = 0, blocks_read = 0;  // in the region
  uint64_t voxel_bytes = 0;             // stored voxels that were read
  double seconds = 0;
};

// The least of SurfaceRequest::memory_bytes that works.
uint64_t leastSurfaceBytes(const SurfaceRequest& request);

// Writes the surface into `file`, which the caller commits. Adds the bytes of voxels to be read to
// the total of `progress`. Throws Error from the source and the file, or if the memory is too
// little, naming the least that works; Interrupted.
SurfaceReport makeSurface(const SurfaceRequest& request, MeshFile& file, WorkerPool& pool,
                          ProgressMeter& progress);

}  // namespace sluice
