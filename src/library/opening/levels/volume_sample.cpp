#include "src/library/opening/levels/volume_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "io/lent_source.h"
#include "src/base/memory/aligned_array.h"
#include "src/base/sources/forwarding_source.h"
#include "src/base/sources/read_units.h"
#include "src/base/threads/clock.h"
#include "src/library/opening/levels/coarsest_level.h"

namespace sluice {
namespace {

// A plane of the grid: a picture of 512 pixels a side shows no more.
constexpr int64_t kMostPlaneVoxels = int64_t{1} << 18;
constexpr int64_t kMostVoxels = int64_t{1} << 26;
// Slices, or chunks along an axis, that are read first.
constexpr int64_t kFirstSlices = 16, kFirstChunks = 4;
// A first pass over files reads at least so many bytes a second.
constexpr double kPassBytesPerSecond = 150e6;
constexpr double kLeastSeconds = 0.01;
// Reads that wait for a disk at the same time: one alone gets a third of what it can deliver.
constexpr int kReaders = 8;
constexpr int64_t kMostReadBytes = int64_t{4} << 20;
// Rows that lie farther apart are read alone, so many of them by the same thread.
constexpr int64_t kLeastGapBytes = int64_t{64} << 10;
constexpr int64_t kRowsATask = 16;

// The points of the grid along an axis.
struct AxisGrid {
  int64_t step = 1, first = 0, count = 0;

  int64_t at(int64_t point) const { return first + point * step; }
  // The first point at this position or beyond it.
  int64_t pointFrom(int64_t position) const {
    return position <= first ? 0 : (position - first + step - 1) / step;
  }
};

AxisGrid gridOf(int64_t extent, int64_t step) {
  const int64_t first = std::min(step / 2, extent - 1);
  return {step, first, (extent - 1 - first) / step + 1};
}

using Grid = std::array<AxisGrid, 3>;

Vec3i dimsOf(const Grid& grid) {
  return {grid[0].count, grid[1].count, grid[2].count};
}

// The finest grid that the memory has room for. A grid along z is no finer than along x and y.
Grid finestGrid(const VolumeLayout& layout, uint64_t most_bytes) {
  const Vec3i dims = layout.dims;
  const auto most = std::clamp<int64_t>(
      static_cast<int64_t>(std::min<uint64_t>(most_bytes, INT64_MAX) / bytesPerVoxel(layout.type)),
      8, kMostVoxels);
  Vec3i step{1, 1, 1};
  const auto points = [&](int axis) { return gridOf(dims[axis], step[axis]).count; };
  const auto coarsen = [&](int axis) {
    if (gridOf(dims[axis], 2 * step[axis]).count < 2) return false;
    step[axis] *= 2;
    return true;
  };
  const auto coarsenPlane = [&] {
    // The axis with the finer step, or else with more points, is coarsened first, so that steps
    // stay alike.
    const bool is_x = step.x == step.y ? points(0) >= points(1) : step.x < step.y;
    return coarsen(is_x ? 0 : 1) || coarsen(is_x ? 1 : 0);
  };
  while (points(0) * points(1) > std::min(kMostPlaneVoxels, most / 2))
    if (!coarsenPlane()) break;
  while (step.z < std::max(step.x, step.y) && points(2) >= 2 * kFirstSlices)
    if (!coarsen(2)) break;
  while (points(0) * points(1) * points(2) > most) {
    const bool is_z = step.z <= std::min(step.x, step.y);
    if (!(is_z && coarsen(2)) && !coarsenPlane() && !coarsen(2)) break;
  }
  if (step == Vec3i{1, 1, 1}) coarsen(2);  // a level is coarser than the volume
  return {gridOf(dims.x, step.x), gridOf(dims.y, step.y), gridOf(dims.z, step.z)};
}

// Reads the voxels of the grid.
class Sampler {
 public:
  explicit Sampler(const SampleRequest& request)
      : request_(request),
        layout_(request.source.layout()),
        voxel_bytes_(static_cast<int64_t>(bytesPerVoxel(layout_.type))),
        units_(readUnits(request.source)),
        most_bytes_(request.memory_bytes / kSampleMemoryShare),
        grid_(finestGrid(layout_, most_bytes_)) {
    // Threads that only wait for a disk cost nothing; those that decode are as many as processors.
    if (request.source.heldBytesAThread() == 0 && !units_.is_one_stream) readers_.emplace(kReaders);
    rooms_.resize(static_cast<size_t>(threads().threads()) + 1);
    const Vec3i dims = dimsOf(grid_);
    sample_.voxels.resize(static_cast<size_t>(volume(dims) * voxel_bytes_));
  }

  VolumeSample run() {
    if (units_.voxels.z == 1)
      readSlices();
    else
      readChunks();
    sample_.dims = dimsOf(grid_);
    for (int a = 0; a < 3; ++a) {
      const AxisGrid& axis = grid_[static_cast<size_t>(a)];
      sample_.placement.scale[a] = static_cast<double>(axis.step);
      sample_.placement.offset[a] = static_cast<double>(axis.first);
    }
    return std::move(sample_);
  }

 private:
  // Voxels as a thread reads them.
  struct Room {
    AlignedArray<std::byte> voxels;
    size_t bytes = 0;
  };

  // Reads as many rounds as the time allows: `read(step)` reads the parts at that step which were
  // not read before, from `first` on in steps that halve. Returns the last step. `growth`: parts of
  // a round for each of those read before.
  template <class Read>
  int64_t rounds(int64_t first, double growth, const Read& read) const {
    const Stopwatch watch;
    read(first, 2 * first);
    int64_t step = first;
    // The next round reads `growth` times as much as all rounds so far, so it is estimated from
    // their time.
    while (step > 1 && watch.seconds() * (1 + growth) <= request_.seconds) {
      read(step / 2, step);
      step /= 2;
    }
    return step;
  }

  // Slices at a step of so many points of the grid.
  void readSlices() {
    AxisGrid& z = grid_[2];
    int64_t first = 1;
    while (z.count / (2 * first) >= kFirstSlices) first *= 2;
    bool is_first = true;
    const int64_t step = rounds(first, 1, [&](int64_t points, int64_t read_before) {
      std::vector<int64_t> slices;
      for (int64_t i = 0; i < z.count; i += points)
        if (is_first || i % read_before != 0) slices.push_back(i);
      is_first = false;
      readPlanes(slices);
    });
    const auto plane = static_cast<size_t>(grid_[0].count * grid_[1].count * voxel_bytes_);
    const int64_t read = (z.count - 1) / step + 1;
    // Slices that were read lie at every `step`-th place; they move together, each to a place
    // before its own.
    for (int64_t i = 1; i < read && step > 1; ++i)
      std::memcpy(sample_.voxels.data() + static_cast<size_t>(i) * plane,
                  sample_.voxels.data() + static_cast<size_t>(i * step) * plane, plane);
    sample_.voxels.resize(static_cast<size_t>(read) * plane);
    sample_.voxels.shrink_to_fit();
    z = {z.step * step, z.first, read};
    sample_.part = fmt::format("{} of {} slices", read, layout_.dims.z);
  }

  // Planes of the grid.
  void readPlanes(const std::vector<int64_t>& planes) {
    const AxisGrid &y = grid_[1], &z = grid_[2];
    const int64_t row_bytes = layout_.dims.x * voxel_bytes_;
    // Rows that lie close together come with one read faster than with many.
    const bool reads_rows = units_.voxels.y == 1 && (y.step - 1) * row_bytes >= kLeastGapBytes;
    const int64_t rows_a_read =
        reads_rows ? 1 : std::max<int64_t>(1, readBytes() / row_bytes / y.step);
    // One thread decodes a slice.
    const int64_t rows_a_task = units_.voxels.y > 1 ? y.count
                                : reads_rows        ? kRowsATask
                                                    : rows_a_read;
    const int64_t tasks = (y.count + rows_a_task - 1) / rows_a_task;
    each(static_cast<int64_t>(planes.size()) * tasks, [&](int64_t task) {
      const int64_t at_z = z.at(planes[static_cast<size_t>(task / tasks)]);
      const int64_t begin = task % tasks * rows_a_task;
      const int64_t end = std::min(begin + rows_a_task, y.count);
      for (int64_t row = begin; row < end; row += rows_a_read) {
        const int64_t last = std::min(row + rows_a_read, end) - 1;
        readBox({{0, y.at(row), at_z}, {layout_.dims.x, y.at(last) + 1, at_z + 1}});
      }
    });
  }

  // Whole chunks at a step of so many chunks along each axis.
  void readChunks() {
    const Vec3i dims = layout_.dims;
    // Each has a point of the grid.
    Vec3i unit, chunks;
    int64_t first = 1;
    for (int a = 0; a < 3; ++a) {
      const int64_t step = grid_[static_cast<size_t>(a)].step, size = units_.voxels[a];
      unit[a] = (step + size - 1) / size * size;
      chunks[a] = (dims[a] + unit[a] - 1) / unit[a];
      while (chunks[a] / (2 * first) >= kFirstChunks) first *= 2;
    }
    bool is_first = true;
    int64_t read = 0;
    const int64_t step = rounds(first, 7, [&](int64_t distance, int64_t read_before) {
      std::vector<Vec3i> places;
      for (int64_t z = 0; z < chunks.z; z += distance)
        for (int64_t y = 0; y < chunks.y; y += distance)
          for (int64_t x = 0; x < chunks.x; x += distance)
            if (is_first || x % read_before != 0 || y % read_before != 0 || z % read_before != 0)
              places.push_back({x, y, z});
      is_first = false;
      read += static_cast<int64_t>(places.size());
      each(static_cast<int64_t>(places.size()), [&](int64_t i) {
        const Vec3i at = places[static_cast<size_t>(i)];
        readSlabs({at * unit, min((at + Vec3i{1, 1, 1}) * unit, dims)});
      });
    });
    if (step > 1) spread(unit * step, unit);
    sample_.part = fmt::format("{} of {} chunks", read, volume(chunks));
  }

  // Gives points between the boxes of `size` voxels that were read, one every `distance` voxels,
  // the value of the nearest point in a box.
  void spread(Vec3i distance, Vec3i size) {
    const Vec3i dims = dimsOf(grid_);
    std::array<std::vector<int64_t>, 3> nearest;
    for (int a = 0; a < 3; ++a) {
      const AxisGrid& axis = grid_[static_cast<size_t>(a)];
      const auto isRead = [&](int64_t i) { return axis.at(i) % distance[a] < size[a]; };
      for (int64_t i = 0; i < axis.count; ++i) {
        int64_t away = 0;
        while ((i - away < 0 || !isRead(i - away)) && (i + away >= axis.count || !isRead(i + away)))
          ++away;
        nearest[static_cast<size_t>(a)].push_back(i - away >= 0 && isRead(i - away) ? i - away
                                                                                    : i + away);
      }
    }
    const auto row_bytes = static_cast<size_t>(dims.x * voxel_bytes_);
    const size_t plane_bytes = row_bytes * static_cast<size_t>(dims.y);
    const auto voxel = static_cast<size_t>(voxel_bytes_);
    // Along x, then y, then z: each pass copies only from rows or planes that the one before has
    // filled.
    for (int64_t z = 0; z < dims.z; ++z) {
      if (nearest[2][static_cast<size_t>(z)] != z) continue;
      std::byte* const plane = sample_.voxels.data() + static_cast<size_t>(z) * plane_bytes;
      for (int64_t y = 0; y < dims.y; ++y) {
        if (nearest[1][static_cast<size_t>(y)] != y) continue;
        std::byte* const row = plane + static_cast<size_t>(y) * row_bytes;
        for (size_t x = 0; x < static_cast<size_t>(dims.x); ++x)
          std::memmove(row + x * voxel, row + static_cast<size_t>(nearest[0][x]) * voxel, voxel);
      }
      for (size_t y = 0; y < static_cast<size_t>(dims.y); ++y)
        std::memmove(plane + y * row_bytes, plane + static_cast<size_t>(nearest[1][y]) * row_bytes,
                     row_bytes);
    }
    for (size_t z = 0; z < static_cast<size_t>(dims.z); ++z)
      std::memmove(sample_.voxels.data() + z * plane_bytes,
                   sample_.voxels.data() + static_cast<size_t>(nearest[2][z]) * plane_bytes,
                   plane_bytes);
  }

  WorkerPool& threads() { return readers_ ? *readers_ : request_.pool; }

  template <class Body>
  void each(int64_t count, const Body& body) {
    threads().parallelFor(count, [&](int64_t i) {
      request_.stop.throwIfStopped();
      body(i);
    });
  }

  // The most bytes that a thread reads at a time.
  int64_t readBytes() const {
    return std::clamp<int64_t>(static_cast<int64_t>(most_bytes_ / kReaders), 1, kMostReadBytes);
  }

  // A chunk that is larger stays decoded in the source's cache from slab to slab.
  void readSlabs(const Box3& box) {
    const Vec3i size = box.size();
    const int64_t planes = std::max<int64_t>(1, readBytes() / (size.x * size.y * voxel_bytes_));
    for (int64_t z = box.lo.z; z < box.hi.z; z += planes)
      readBox({{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, std::min(z + planes, box.hi.z)}});
  }

  // Reads a box and keeps the points of the grid in it.
  void readBox(const Box3& box) {
    Box3 points;
    for (int a = 0; a < 3; ++a) {
      const AxisGrid& axis = grid_[static_cast<size_t>(a)];
      points.lo[a] = axis.pointFrom(box.lo[a]);
      points.hi[a] = std::min(axis.pointFrom(box.hi[a]), axis.count);
    }
    if (points.empty()) return;
    Room& room = rooms_[static_cast<size_t>(threads().self())];
    const auto bytes = static_cast<size_t>(box.count() * voxel_bytes_);
    if (bytes > room.bytes) room = {alignedForOverwrite<std::byte>(bytes), bytes};
    request_.source.readRegion(request_.time, box, {room.voxels.get(), bytes});
    visitVoxelType(layout_.type,
                   [&](auto tag) { keep<decltype(tag)>(box, points, room.voxels.get()); });
  }

  template <class T>
  void keep(const Box3& box, const Box3& points, const std::byte* voxels) {
    const Vec3i dims = dimsOf(grid_), size = box.size();
    T* const all = reinterpret_cast<T*>(sample_.voxels.data());
    const int64_t step = grid_[0].step;
    for (int64_t z = points.lo.z; z < points.hi.z; ++z)
      for (int64_t y = points.lo.y; y < points.hi.y; ++y) {
        const Vec3i at = Vec3i{grid_[0].at(points.lo.x), grid_[1].at(y), grid_[2].at(z)} - box.lo;
        const T* const from =
            reinterpret_cast<const T*>(voxels) + (at.z * size.y + at.y) * size.x + at.x;
        T* const to = all + (z * dims.y + y) * dims.x;
        for (int64_t x = points.lo.x; x < points.hi.x; ++x) to[x] = from[(x - points.lo.x) * step];
      }
  }

  const SampleRequest& request_;
  const VolumeLayout& layout_;
  const int64_t voxel_bytes_;
  const ReadUnits units_;
  const uint64_t most_bytes_;
  Grid grid_;
  std::optional<WorkerPool> readers_;  // unset: request_.pool
  std::vector<Room> rooms_;            // of each thread
  VolumeSample sample_;
};

class SampledVolume final : public ForwardingSource {
 public:
  SampledVolume(std::unique_ptr<VolumeSource> source, VolumeSample sample)
      : ForwardingSource(std::move(source)), sample_(std::move(sample)) {
    VolumeLayout layout = ForwardingSource::layout();
    layout.dims = sample_.dims;
    source_of_level_ =
        lentSource(fillFrom(sample_.voxels.data(), layout, packedStrides(layout)), layout);
    const std::span<const CoarserLevel> own = ForwardingSource::levelsAbove();
    levels_.assign(own.begin(), own.end());
    const LevelPlacement below = own.empty() ? LevelPlacement() : own.back().placement;
    levels_.push_back({source_of_level_.get(), placedAbove(below, sample_.placement), nullptr});
  }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_; }

 private:
  const VolumeSample sample_;
  std::unique_ptr<VolumeSource> source_of_level_;  // constant after construction, as all of it
  std::vector<CoarserLevel> levels_;
};

}  // namespace

VolumeSample sampleVolume(const SampleRequest& request) {
  return Sampler(request).run();
}

bool isWorthSampling(const VolumeLayout& layout, double seconds) {
  const Vec3d dims = toDouble(layout.dims);
  const double bytes = dims.x * dims.y * dims.z * static_cast<double>(bytesPerVoxel(layout.type));
  return std::min({dims.x, dims.y, dims.z}) >= 4 &&
         bytes > std::max(seconds, kLeastSeconds) * kPassBytesPerSecond;
}

std::unique_ptr<VolumeSource> withSample(std::unique_ptr<VolumeSource> source,
                                         VolumeSample sample) {
  return std::make_unique<SampledVolume>(std::move(source), std::move(sample));
}

}  // namespace sluice
