#include "src/library/opening/levels/stand_in.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <type_traits>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/blocks/cut/level_cut.h"
#include "src/render/blocks/look.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {
namespace {

// The greatest spread of the voxels with nearly the same mean.
constexpr size_t kBins = 256;
using SpreadBins = std::array<double, kBins>;

// A brick a cell for a level of kLeastStandInVoxels. A fit by larger bricks of coarse cells would
// be looser by some per cent than that of the finest level.
constexpr int64_t kMostReachBricks = kLeastStandInVoxels;

// Cubes of so many voxels a side are read at a time: about the chunks that most programs write.
constexpr int64_t kReadSide = 64;

template <class T>
std::vector<T> deviceVoxels(VolumeSource& source, int64_t time, const Box3& box) {
  std::vector<T> voxels(static_cast<size_t>(box.count()));
  DeviceReader(source).read(time, {box, std::as_writable_bytes(std::span(voxels))});
  return voxels;
}

// Values that lie `below` their mean at the farthest reach at least so far above it if they have
// this spread: two values alone. Rounded means near the end would ask for too much.
constexpr double kMostDeviations = 4;
double leastReach(double spread, double below) {
  const double deviation = spread / 2;
  return std::min(deviation * deviation / std::max(below, 1e-300), kMostDeviations * deviation);
}
// How far such a voxel's values are taken to reach above its mean: evenly to both sides, or farther
// if the range ends below, since uniform parts of lengths a and b have the variance a * b / 3.
double drawnReach(double spread, double below) {
  const double even = std::numbers::sqrt3 * spread / 2;
  return below < even ? std::max(even, 3 * leastReach(spread, below)) : even;
}

// The ranges of the planes of a box along each axis, or of a volume.
template <class T>
using PlanesOf = std::array<std::vector<PlaneRange<T>>, 3>;

template <class T>
PlanesOf<T> noPlanes(Vec3i size) {
  PlanesOf<T> planes;
  for (int a = 0; a < 3; ++a)
    planes[static_cast<size_t>(a)].resize(static_cast<size_t>(size[a]), kNoVoxels<T>);
  return planes;
}

// Widens the planes of a box by the voxels' ranges, x fastest. kNotANumber is no value.
template <class T>
void widenPlanes(PlanesOf<T>& planes, const std::vector<T>& least, const std::vector<T>& greatest,
                 Vec3i size) {
  size_t at = 0;
  for (size_t z = 0; z < static_cast<size_t>(size.z); ++z)
    for (size_t y = 0; y < static_cast<size_t>(size.y); ++y) {
      PlaneRange<T> row = kNoVoxels<T>;
      for (size_t x = 0; x < static_cast<size_t>(size.x); ++x, ++at) {
        if constexpr (std::is_same_v<T, float>)
          if (least[at] == kNotANumber) continue;
        const PlaneRange<T> own{least[at], greatest[at]};
        widen(planes[0][x], own);
        widen(row, own);
      }
      widen(planes[1][y], row);
      widen(planes[2][z], row);
    }
}

// Adds the values that these voxels are drawn with to the bricks around them. Returns those of the
// box's planes.
template <class T>
PlanesOf<T> addReach(BrickRangesBuilder<T>& bricks, const std::vector<T>& mean,
                     const std::vector<T>& spread, ValueRange means, const Box3& box) {
  std::vector<T> least(mean.size()), greatest(mean.size());
  const auto within = [](double value) {
    if constexpr (std::is_integral_v<T>)
      value = std::clamp(value, 0.0, double{std::numeric_limits<T>::max()});
    return static_cast<T>(value);
  };
  for (size_t i = 0; i < mean.size(); ++i) {
    const auto middle = static_cast<double>(mean[i]), wide = static_cast<double>(spread[i]);
    const bool is_value = middle >= means.lo && middle <= means.hi && wide > 0;
    least[i] = is_value ? within(middle - drawnReach(wide, means.hi - middle)) : mean[i];
    greatest[i] =
        is_value ? within(std::ceil(middle + drawnReach(wide, middle - means.lo))) : mean[i];
  }
  bricks.add(least.data(), greatest.data(), box);
  PlanesOf<T> planes = noPlanes<T>(box.size());
  widenPlanes(planes, least, greatest, box.size());
  return planes;
}

template <class T>
struct SpreadsOfBox {
  SpreadBins most;
  PlanesOf<T> planes;
};

template <class T>
SpreadsOfBox<T> spreadsIn(const CoarserLevel& level, ValueRange means, int64_t time,
                          const Box3& box, BrickRangesBuilder<T>& bricks) {
  const std::vector<T> mean = deviceVoxels<T>(*level.source, time, box);
  const std::vector<T> spread = deviceVoxels<T>(*level.spreads, time, box);
  const double bins_per_device = (kBins - 1) / std::max(means.hi - means.lo, 1e-300);
  SpreadBins most{};
  for (size_t i = 0; i < mean.size(); ++i) {
    const double bin = (static_cast<double>(mean[i]) - means.lo) * bins_per_device + 0.5;
    if (!(bin >= 0) || bin >= kBins) continue;  // no number, or infinite
    double& spread_of_bin = most[static_cast<size_t>(bin)];
    spread_of_bin = std::max(spread_of_bin, static_cast<double>(spread[i]));
  }
  return {most, addReach(bricks, mean, spread, means, box)};
}

// The range of values that voxels of this device type can have.
ValueRange valuesOf(DeviceType type) {
  switch (type) {
    case DeviceType::kU8:
      return {0, std::numeric_limits<uint8_t>::max()};
    case DeviceType::kU16:
      return {0, std::numeric_limits<uint16_t>::max()};
    case DeviceType::kF32:
      break;
  }
  return {-double{kLargest}, double{kLargest}};
}

}  // namespace

int standInLevel(const PyramidLayout& pyramid) {
  int level = pyramid.levels() - 1;
  while (level > 1 && volume(pyramid.level(level).blocks.dims) < kLeastStandInVoxels) --level;
  return level;
}

namespace {

// The greatest spreads, and the values of bricks and planes with them.
template <class T>
SpreadBins readSpreads(const CoarserLevel& level, ValueRange means, int64_t time, WorkerPool& pool,
                       const StopToken& stop, ReachRanges& reach) {
  const VolumeLayout& layout = level.source->layout();
  const auto countAlong = [&](int axis) { return (layout.dims[axis] + kReadSide - 1) / kReadSide; };
  const Vec3i reads{countAlong(0), countAlong(1), countAlong(2)};
  BrickRangesBuilder<T> builder(reach.bricks);
  SpreadBins most{};
  PlanesOf<T> planes = noPlanes<T>(layout.dims);
  Mutex mutex;  // guards `most` and `planes`
  // Threads that wait for a server cost nothing.
  std::optional<WorkerPool> waiting;
  if (const int distant = level.spreads->distantReads(); distant > pool.threads())
    waiting.emplace(distant);
  (waiting ? *waiting : pool).parallelFor(volume(reads), [&](int64_t i) {
    stop.throwIfStopped();
    const Vec3i lo = Vec3i{i % reads.x, i / reads.x % reads.y, i / (reads.x * reads.y)} * kReadSide;
    const Box3 box{lo, min(lo + Vec3i{kReadSide, kReadSide, kReadSide}, layout.dims)};
    const SpreadsOfBox<T> found = spreadsIn<T>(level, means, time, box, builder);
    const MutexLock lock(mutex);
    for (size_t bin = 0; bin < kBins; ++bin) most[bin] = std::max(most[bin], found.most[bin]);
    for (int a = 0; a < 3; ++a)
      for (int64_t p = box.lo[a]; p < box.hi[a]; ++p)
        widen(planes[static_cast<size_t>(a)][static_cast<size_t>(p)],
              found.planes[static_cast<size_t>(a)][static_cast<size_t>(p - box.lo[a])]);
  });
  reach.bricks = builder.finish();
  for (size_t a = 0; a < 3; ++a) {
    const auto bytes = std::as_bytes(std::span(planes[a]));
    reach.planes.along[a].assign(bytes.begin(), bytes.end());
  }
  return most;
}

// Cuts the values of bricks or planes to a range, which none leaves in pictures.
template <class T>
void cutTo(ValueRange range, std::vector<std::byte>& ranges) {
  const auto lo = static_cast<T>(range.lo), hi = static_cast<T>(range.hi);
  auto* const each = reinterpret_cast<PlaneRange<T>*>(ranges.data());
  for (size_t i = 0; i < ranges.size() / sizeof(PlaneRange<T>); ++i)
    if (each[i].lo <= each[i].hi)
      each[i] = {std::clamp(each[i].lo, lo, hi), std::clamp(each[i].hi, lo, hi)};
}

// The range that means within `means` and these spreads ask for.
ValueRange widened(ValueRange means, const SpreadBins& most) {
  const auto meanOf = [&](size_t bin) {
    return means.lo + (means.hi - means.lo) * static_cast<double>(bin) / (kBins - 1);
  };
  ValueRange range = means;
  const auto widenUp = [&] {
    for (size_t bin = 0; bin < kBins; ++bin)
      range.hi = std::max(range.hi, meanOf(bin) + leastReach(most[bin], meanOf(bin) - range.lo));
  };
  const auto widenDown = [&] {
    for (size_t bin = 0; bin < kBins; ++bin)
      range.lo = std::min(range.lo, meanOf(bin) - leastReach(most[bin], range.hi - meanOf(bin)));
  };
  // The end whose voxels differ least is the values' own.
  if (most.front() <= most.back()) {
    widenUp();
    widenDown();
  } else {
    widenDown();
    widenUp();
  }
  return range;
}

}  // namespace

SpreadReach reachOfSpreads(const CoarserLevel& level, ValueRange means, const Box3& cells,
                           int64_t time, WorkerPool& pool, const StopToken& stop) {
  const DeviceType type = deviceMap(level.source->layout()).type;
  SpreadReach reach{{}, {brickGrid(cells, kMostReachBricks), {}}};
  const SpreadBins most = visitDeviceType(type, [&](auto tag) {
    return readSpreads<decltype(tag)>(level, means, time, pool, stop, reach.drawn);
  });
  const ValueRange range = widened(means, most), all = valuesOf(type);
  reach.range = {std::max(range.lo, all.lo), std::min(range.hi, all.hi)};
  visitDeviceType(type, [&](auto tag) {
    cutTo<decltype(tag)>(reach.range, reach.drawn.bricks.ranges);
    for (auto& planes : reach.drawn.planes.along) cutTo<decltype(tag)>(reach.range, planes);
  });
  return reach;
}

uint64_t reachBytes(Vec3i dims, DeviceType type) {
  const Vec3i bricks = brickGrid(brickCells(dims, std::nullopt), kMostReachBricks).grid();
  const int64_t planes = dims.x + dims.y + dims.z;
  constexpr uint64_t kEnds = 2, kCopies = 2;
  return kCopies * kEnds * bytesPerVoxel(type) * static_cast<uint64_t>(volume(bricks) + planes);
}

bool showsFinest(const TimeStep& step, const TransferFunction& transfer, FrameOptions frame,
                 std::span<const Camera> cameras, WorkerPool& pool) {
  if (!drawsCut(step, frame.cut, frame.mode, transfer)) return true;
  LevelCut chooser(pool);
  const auto look = std::make_shared<const Look>(makeLook(step, transfer, frame.mode));
  const VolumeLayout& layout = step.source->layout();
  return std::ranges::any_of(cameras, [&](const Camera& camera) {
    const View view = resolve(camera, layout, frame.size, frame.step_vox);
    const VisibleBlocksPtr blocks =
        chooser.choose({step, look, cropCells(frame, layout.dims), view, *frame.cut});
    return !blocks->blocks.empty() && blocks->blocks.front().name.level == 0;
  });
}

}  // namespace sluice
