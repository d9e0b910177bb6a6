#include "src/surface/surface.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/threads/mutex.h"
#include "src/base/values/bytes.h"
#include "src/surface/ordered_parts.h"
#include "src/surface/piece_mesher.h"
#include "src/surface/vertex_numbers.h"
#include "src/volume/ranges/block_ranges.h"

namespace sluice {
namespace {

// Longer rows cost memory and save no more time.
constexpr int64_t kMostRowBlocks = 8;
// Rows are as long as leaves memory for so many threads. The number of threads that there are plays
// no part: the order of the mesh follows from the rows.
constexpr int kThreadsToFit = 8;

// The stored voxels of a block, for the progress.
uint64_t blockBytes(const SurfaceRequest& request) {
  const int64_t side = request.states.layout.size;
  return static_cast<uint64_t>(side * side * side) * bytesPerVoxel(request.source.layout().type);
}

// The threads that make pieces, and the length of these.
struct Shares {
  int64_t row_blocks = 1;
  int threads = 1;
  uint64_t waiting_bytes = 0;  // for finished pieces
};

// The most that a thread holds for a piece.
uint64_t pieceBytes(const SurfaceRequest& request, int64_t row_blocks) {
  const BlockLayout& layout = request.states.layout;
  const int64_t cells = layout.cells();
  const Vec3i voxels = min(Vec3i{row_blocks * cells, cells, cells}, layout.dims) + Vec3i{3, 3, 3};
  const auto rows = static_cast<uint64_t>(voxels.y * voxels.z);
  const VolumeLayout& stored = request.source.layout();
  const uint64_t bits = rows * static_cast<uint64_t>(voxels.x / 64 + 2) * sizeof(uint64_t);
  constexpr uint64_t kNumbers = 6;  // of a row
  return rows * static_cast<uint64_t>(voxels.x) * bytesPerVoxel(deviceMap(stored).type) +
         DeviceReader::kScratchBytes + bits + rows * kNumbers * sizeof(uint64_t) +
         PieceMesher::heldBytes(voxels) + request.source.heldBytesAThread();
}

// The bytes of so many threads.
uint64_t threadsBytes(const SurfaceRequest& request, int64_t row_blocks, int threads) {
  return pieceBytes(request, row_blocks) * static_cast<uint64_t>(threads) + PieceMesher::kPartBytes;
}

Shares sharesFor(const SurfaceRequest& request, int threads) {
  const auto needs = [&](int64_t row_blocks, int of) {
    return threadsBytes(request, row_blocks, of);
  };
  Shares shares{std::min(kMostRowBlocks, request.states.layout.grid.x), threads};
  while (shares.row_blocks > 1 && needs(shares.row_blocks, kThreadsToFit) > request.memory_bytes)
    shares.row_blocks /= 2;
  while (shares.threads > 1 && needs(shares.row_blocks, shares.threads) > request.memory_bytes)
    --shares.threads;
  const uint64_t least = needs(shares.row_blocks, shares.threads);
  if (least > request.memory_bytes)
    failMemory(
        "{}: a surface needs at least {} for its voxels and triangles, {} are left of --memory",
        request.source.layout().calledBy(), formatBytes(least), formatBytes(request.memory_bytes));
  shares.waiting_bytes =
      std::min(PieceMesher::kPartBytes * static_cast<uint64_t>(4 * shares.threads),
               PieceMesher::kPartBytes + (request.memory_bytes - least) / 2);
  return shares;
}

// Makes pieces until none is left; shared by all threads.
class SurfaceRun {
 public:
  SurfaceRun(const SurfaceRequest& request, const Shares& shares, MeshFile& file,
             ProgressMeter& progress)
      : request_(request),
        file_(file),
        progress_(progress),
        grid_(request.states.layout, request.region, shares.row_blocks),
        ids_(grid_.mixedPieces(request.states)),
        numbers_(grid_, ids_),
        parts_(file, shares.waiting_bytes) {}

  // On one thread.
  void work() {
    try {
      Workspace space{PieceVoxels(request_.source),
                      {},
                      {},
                      PieceMesher(file_,
                                  {request_.place, request_.inside,
                                   deviceMap(request_.source.layout()).scale < 0 ? 1.0 : -1.0},
                                  request_.stop)};
      // Pieces are begun in the order in which they are numbered and written. The earliest
      // unfinished one is therefore always on a thread that waits for nobody, and the others' waits
      // end.
      for (size_t at = next_++; at < ids_.size(); at = next_++) {
        request_.stop.throwIfStopped();
        if (!make(at, space)) return;
      }
    } catch (...) {
      // Other threads may be waiting for the numbers or the parts of this piece.
      numbers_.giveUp();
      parts_.giveUp();
      throw;
    }
  }

  uint64_t voxelBytes() const { return voxel_bytes_; }

 private:
  struct Workspace {
    PieceVoxels voxels;
    CornerBits bits;
    RowNumbers numbers;
    PieceMesher mesher;
  };

  bool make(size_t at, Workspace& space) {
    const Piece piece = grid_.piece(ids_[at]);
    space.voxels.read(request_.time, grid_, piece, request_.states);
    visitDeviceType(space.voxels.type(), [&](auto tag) {
      // This comes first: min-max arrays of other voxels would leave holes in the surface.
      checkBlocks<decltype(tag)>(space.voxels);
      setBits<decltype(tag)>(piece, space);
    });
    countVertices(piece, space.bits, space.numbers);
    if (!numbers_.number(at, piece, space.bits, space.numbers)) return false;
    const bool is_whole = space.mesher.mesh(
        {piece, request_.region, space.bits, space.numbers, space.voxels},
        [&](MeshPart& part, bool is_last) { return parts_.put(at, part, is_last); });
    voxel_bytes_ += space.voxels.storedBytes();
    progress_.add(space.voxels.blocks() * blockBytes(request_));
    return is_whole;
  }

  // Compares blocks that were read whole with the arrays that chose them.
  template <class T>
  void checkBlocks(const PieceVoxels& voxels) const {
    if (!request_.check) return;
    const BlockLayout& layout = grid_.layout();
    for (const VoxelRun& run : voxels.runs())
      for (Vec3i index = run.blocks.lo; index.x < run.blocks.hi.x; ++index.x) {
        const Box3 cells = layout.ownedCells(index);
        // The part of a block within the region may have a narrower range than the arrays tell.
        if (!run.cells.contains(cells)) continue;
        const Vec3i size = run.voxels.size(), local = cells.lo - run.voxels.lo;
        const T* const first =
            reinterpret_cast<const T*>(run.bytes) + (local.z * size.y + local.y) * size.x + local.x;
        // The voxels of a block are one more along each axis than its cells: it shares the last
        // ones with its neighbours.
        const PlaneRange<T> range =
            rangeOf(first, cells.size() + Vec3i{1, 1, 1}, size.x, size.x * size.y);
        request_.check(layout.idOf(index), static_cast<double>(range.lo),
                       static_cast<double>(range.hi));
      }
  }

  template <class T>
  void setBits(const Piece& piece, Workspace& space) const {
    space.bits.reset(piece.voxels());
    setKnownBlocks(piece, space.bits);
    constexpr T kLeast = std::numeric_limits<T>::lowest(), kMost = std::numeric_limits<T>::max();
    // The clamp keeps the conversion defined. A threshold beyond all values of the type leaves no
    // block mixed whose range is known.
    const T lo = atLeast<T>(std::clamp(request_.inside.lo, double{kLeast}, double{kMost}));
    const T hi = atMost<T>(std::clamp(request_.inside.hi, double{kLeast}, double{kMost}));
    for (const VoxelRun& run : space.voxels.runs()) {
      const Vec3i size = run.voxels.size(), at = run.cells.lo - piece.cells.lo;
      for (int64_t z = run.cells.lo.z; z <= run.cells.hi.z; ++z)
        for (int64_t y = run.cells.lo.y; y <= run.cells.hi.y; ++y) {
          const Vec3i local = Vec3i{run.cells.lo.x, y, z} - run.voxels.lo;
          const T* const row = reinterpret_cast<const T*>(run.bytes) +
                               (local.z * size.y + local.y) * size.x + local.x;
          space.bits.setInside(y - piece.cells.lo.y, z - piece.cells.lo.z, at.x, row,
                               run.cells.size().x + 1, lo, hi);
        }
    }
  }

  // The blocks that were not read, since they are inside as a whole.
  void setKnownBlocks(const Piece& piece, CornerBits& bits) const {
    const BlockLayout& layout = grid_.layout();
    for (Vec3i index = piece.blocks.lo; index.x < piece.blocks.hi.x; ++index.x) {
      const Box3 cells = intersect(layout.ownedCells(index), request_.region.cells);
      if (cells.empty() || request_.states.stateOf(layout.idOf(index)) != RangeState::kInside)
        continue;
      const Box3 local = translate(cells, -piece.cells.lo);
      for (int64_t z = local.lo.z; z <= local.hi.z; ++z)
        for (int64_t y = local.lo.y; y <= local.hi.y; ++y)
          bits.setInside(y, z, local.lo.x, local.hi.x);
    }
  }

  // The least and the greatest number of the type that is not below, or not above.
  template <class T>
  static T atLeast(double bound) {
    T value = static_cast<T>(bound);
    // The conversion may have rounded to the wrong side of the bound. InsideSet's bounds for whole
    // numbers are whole.
    if constexpr (std::is_same_v<T, float>)
      if (double{value} < bound) value = std::nextafter(value, std::numeric_limits<T>::max());
    return value;
  }
  template <class T>
  static T atMost(double bound) {
    T value = static_cast<T>(bound);
    if constexpr (std::is_same_v<T, float>)
      if (double{value} > bound) value = std::nextafter(value, std::numeric_limits<T>::lowest());
    return value;
  }

  const SurfaceRequest& request_;
  MeshFile& file_;
  ProgressMeter& progress_;
  const PieceGrid grid_;
  const std::vector<int64_t> ids_;  // of the pieces
  VertexNumbers numbers_;
  OrderedParts parts_;
  std::atomic<size_t> next_{0};  // place in ids_
  std::atomic<uint64_t> voxel_bytes_{0};
};

// The blocks in the region: all, and those that are read.
std::pair<int64_t, int64_t> countBlocks(const SurfaceRequest& request) {
  const BlockLayout& layout = request.states.layout;
  // Blocks at the border count even if only some of their cells lie in the region.
  const Box3& cells = request.region.cells;
  int64_t all = 1;
  for (int a = 0; a < 3; ++a)
    all *= (cells.hi[a] - 1) / layout.cells() - cells.lo[a] / layout.cells() + 1;
  const int64_t read =
      std::ranges::count_if(request.states.blocks, [&](const BlockStates::Block& block) {
        return block.state == RangeState::kMixed &&
               !intersect(layout.ownedCells(layout.indexOf(block.id)), cells).empty();
      });
  return {all, read};
}

}  // namespace

uint64_t leastSurfaceBytes(const SurfaceRequest& request) {
  return threadsBytes(request, 1, 1);
}

SurfaceReport makeSurface(const SurfaceRequest& request, MeshFile& file, WorkerPool& pool,
                          ProgressMeter& progress) {
  const Stopwatch watch;
  SurfaceReport report;
  const auto [blocks, read] = countBlocks(request);
  report.blocks = blocks;
  report.blocks_read = read;
  const Shares shares = sharesFor(request, pool.threads());
  progress.expect(static_cast<uint64_t>(read) * blockBytes(request));
  SurfaceRun run(request, shares, file, progress);
  pool.parallelFor(shares.threads, [&](int64_t /*thread*/) { run.work(); });
  report.vertices = file.vertices();
  report.triangles = file.triangles();
  report.voxel_bytes = run.voxelBytes();
  report.seconds = watch.seconds();
  return report;
}

}  // namespace sluice
