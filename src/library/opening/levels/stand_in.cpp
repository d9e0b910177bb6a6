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

// Adds the values that these voxels are drawn with to the bricks around them.
template <class T>
void addReach(BrickRangesBuilder<T>& bricks, const std::vector<T>& mean,
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
  bricks.add(least.data(), box);
  bricks.add(greatest.data(), box);
}

template <class T>
SpreadBins spreadsIn(const CoarserLevel& level, ValueRange means, int64_t time, const Box3& box,
                     BrickRangesBuilder<T>& bricks) {
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
  addReach(bricks, mean, spread, means, box);
  return most;
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

// The greatest spreads, and the bricks' values with them.
template <class T>
SpreadBins readSpreads(const CoarserLevel& level, ValueRange means, int64_t time, WorkerPool& pool,
                       const StopToken& stop, BrickRanges& bricks) {
  const VolumeLayout& layout = level.source->layout();
  const auto countAlong = [&](int axis) { return (layout.dims[axis] + kReadSide - 1) / kReadSide; };
  const Vec3i reads{countAlong(0), countAlong(1), countAlong(2)};
  BrickRangesBuilder<T> builder(bricks);
  SpreadBins most{};
  Mutex mutex;  // guards `most`
  // Threads that wait for a server cost nothing.
  std::optional<WorkerPool> waiting;
  if (const int distant = level.spreads->distantReads(); distant > pool.threads())
    waiting.emplace(distant);
  (waiting ? *waiting : pool).parallelFor(volume(reads), [&](int64_t i) {
    stop.throwIfStopped();
    const Vec3i lo = Vec3i{i % reads.x, i / reads.x % reads.y, i / (reads.x * reads.y)} * kReadSide;
    const Box3 box{lo, min(lo + Vec3i{kReadSide, kReadSide, kReadSide}, layout.dims)};
    const SpreadBins found = spreadsIn<T>(level, means, time, box, builder);
    const MutexLock lock(mutex);
    for (size_t bin = 0; bin < kBins; ++bin) most[bin] = std::max(most[bin], found[bin]);
  });
  bricks = builder.finish();
  return most;
}

// Cuts the values of bricks to a range, which none leaves in pictures.
template <class T>
void cutTo(ValueRange range, BrickRanges& bricks) {
  const auto lo = static_cast<T>(range.lo), hi = static_cast<T>(range.hi);
  auto* const each = reinterpret_cast<PlaneRange<T>*>(bricks.ranges.data());
  for (size_t i = 0; i < bricks.rangesAs<T>().size(); ++i)
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
  SpreadReach reach{{}, brickGrid(cells)};
  const SpreadBins most = visitDeviceType(type, [&](auto tag) {
    return readSpreads<decltype(tag)>(level, means, time, pool, stop, reach.bricks);
  });
  const ValueRange range = widened(means, most), all = valuesOf(type);
  reach.range = {std::max(range.lo, all.lo), std::min(range.hi, all.hi)};
  visitDeviceType(type, [&](auto tag) { cutTo<decltype(tag)>(reach.range, reach.bricks); });
  return reach;
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
