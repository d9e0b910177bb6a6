#include "io/zarr/level_maker.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// The voxels of a block added up so far. Sums of integers are exact: 2^32 times 2^18 voxels are
// below 2^53.
struct Gathered {
  double value = 0;    // sum or greatest
  double squares = 0;  // of the values' distances from the cube's origin
  uint32_t count = 0;  // of voxels that are numbers
};

void gather(Gathered& block, const Gathered& more, Downsample how) {
  if (more.count == 0) return;
  if (how == Downsample::kMean)
    block.value += more.value;
  else
    block.value = block.count == 0 ? more.value : std::max(block.value, more.value);
  block.squares += more.squares;
  block.count += more.count;
}

// The nearest whole number, ties to the even one, as std::nearbyint() without a call. Requires:
// less than 2^51 away from 0.
double rounded(double value) {
  constexpr double kUnitsAreLast = 0x1.8p52;  // above it a double has no fraction
  return (value + kUnitsAreLast) - kUnitsAreLast;
}

// sum / count. Multiplying is faster and the same for powers of two, which most counts are.
double meanOf(double sum, uint32_t count) {
  const bool is_power_of_two = count != 0 && (count & (count - 1)) == 0;
  if (is_power_of_two) return sum * (1.0 / count);
  return sum / count;
}

// Twice the standard deviation. `origin`: what the squares are measured from, a value close to the
// others, so that little is cancelled.
template <class Spread>
Spread spreadOf(const Gathered& block, double origin) {
  if (block.count == 0) return 0;
  const double mean = meanOf(block.value, block.count) - origin;
  const double variance = meanOf(block.squares, block.count) - mean * mean;
  const double spread = 2 * std::sqrt(std::max(0.0, variance));
  if constexpr (std::is_floating_point_v<Spread>)
    return std::isfinite(spread) ? static_cast<Spread>(spread) : Spread{0};
  else
    return static_cast<Spread>(rounded(spread));
}

template <class T>
T resultOf(const Gathered& block, Downsample how) {
  const double value = how == Downsample::kMean ? meanOf(block.value, block.count) : block.value;
  if constexpr (std::is_floating_point_v<T>) {
    if (block.count == 0) return std::numeric_limits<T>::quiet_NaN();
    return static_cast<T>(value);
  } else {
    return static_cast<T>(rounded(value));
  }
}

// The number that stands most often in `values`, which are put in order.
template <class T>
T modeOf(std::vector<T>& values) {
  if (values.empty()) {
    if constexpr (std::is_floating_point_v<T>) return std::numeric_limits<T>::quiet_NaN();
    return T{};
  }
  std::sort(values.begin(), values.end());
  T mode = values.front();
  size_t most = 0;
  for (size_t i = 0; i < values.size();) {
    size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    if (end - i > most) {
      most = end - i;
      mode = values[i];
    }
    i = end;
  }
  return mode;
}

// Blocks of a cube, x fastest.
struct Blocks {
  Vec3i size;
  std::vector<Gathered> of;

  Gathered& at(Vec3i p) { return of[static_cast<size_t>((p.z * size.y + p.y) * size.x + p.x)]; }
};

// All of them empty; keeps the memory.
void makeEmpty(Blocks& blocks, Vec3i size) {
  blocks.size = size;
  blocks.of.assign(static_cast<size_t>(volume(size)), Gathered{});
}

template <class F>
void eachVoxel(Vec3i size, F&& f) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y)
      for (int64_t x = 0; x < size.x; ++x) f(Vec3i{x, y, z});
}

Vec3i roundedUp(Vec3i size, Vec3i step) {
  return {ceilDiv(size.x, step.x), ceilDiv(size.y, step.y), ceilDiv(size.z, step.z)};
}

template <class T>
constexpr bool isNarrow = std::is_integral_v<T> && sizeof(T) <= 2;

template <class T>
bool isNumber(T value) {
  if constexpr (std::is_floating_point_v<T>) return !std::isnan(value);
  return true;
}

}  // namespace

const char* nameOf(Downsample how) {
  if (how == Downsample::kMean) return "mean";
  return how == Downsample::kMax ? "max" : "mode";
}

LevelPlacement placementOf(const LevelShape& shape) {
  const Vec3d step = toDouble(shape.step);
  return {step, (step - Vec3d{1, 1, 1}) * 0.5};
}

std::vector<LevelShape> levelShapes(const VolumeLayout& layout, int64_t chunk_voxels,
                                    std::optional<int64_t> most) {
  std::vector<LevelShape> levels;
  LevelShape level{layout.dims, {1, 1, 1}};
  Vec3d spacing = layout.spacing;
  const auto isEnough = [&] {
    if (most) return static_cast<int64_t>(levels.size()) >= *most;
    return std::max({level.dims.x, level.dims.y, level.dims.z}) <= kCoarsestSide;
  };
  while (!isEnough()) {
    // Axes whose voxels are within half an octave of the shortest that can still be halved.
    double shortest = std::numeric_limits<double>::infinity();
    const auto canHalve = [&](int a) {
      return level.dims[a] > 1 && chunk_voxels % (2 * level.step[a]) == 0;
    };
    for (int a = 0; a < 3; ++a)
      if (canHalve(a)) shortest = std::min(shortest, spacing[a]);
    if (std::isinf(shortest)) break;
    for (int a = 0; a < 3; ++a) {
      if (!canHalve(a) || spacing[a] > shortest * std::sqrt(2.0)) continue;
      level.step[a] *= 2;
      level.dims[a] = ceilDiv(layout.dims[a], level.step[a]);
      spacing[a] *= 2;
    }
    levels.push_back(level);
  }
  return levels;
}

// The blocks of a cube for a level and the one before it.
struct LevelMaker::Scratch {
  Blocks coarser, finer;
};

LevelMaker::~LevelMaker() = default;

LevelMaker::LevelMaker(const VolumeLayout& layout, int64_t chunk_voxels,
                       std::vector<LevelShape> levels, Downsample how,
                       std::span<const std::byte> fill)
    : dims_(layout.dims),
      type_(layout.type),
      chunk_voxels_(chunk_voxels),
      levels_(std::move(levels)),
      how_(how),
      fill_(fill.begin(), fill.end()),
      layers_(levels_.size()),
      spreads_(levels_.size()) {
  for (size_t i = 0; i < levels_.size(); ++i) {
    for (int a = 0; a < 3; ++a) SLUICE_CHECK_EQ(chunk_voxels % levels_[i].step[a], 0);
    clearLayer(i);
  }
}

namespace {

uint64_t layerBytes(const LevelShape& level, int64_t chunk_voxels, size_t voxel) {
  return static_cast<uint64_t>(level.dims.x * level.dims.y * std::min(chunk_voxels, level.dims.z)) *
         voxel;
}

}  // namespace

uint64_t LevelMaker::pendingBytes(const VolumeLayout& layout, int64_t chunk_voxels,
                                  std::span<const LevelShape> levels, Downsample how) {
  uint64_t bytes = 0;
  for (const LevelShape& level : levels)
    bytes += layerBytes(level, chunk_voxels,
                        storedBytesPerVoxel(layout.type, keepsSpreads(how) ? 2 : 1));
  return bytes;
}

uint64_t LevelMaker::threadBytes(const VolumeLayout& layout, int64_t chunk_voxels) {
  const auto side = static_cast<uint64_t>(chunk_voxels);
  // Blocks of the first level, perhaps of one axis halved, and of the second; or a block's voxels.
  return side * side * side * std::max(sizeof(Gathered), bytesPerVoxel(layout.type));
}

void LevelMaker::clearLayer(size_t level) {
  std::vector<std::byte>& layer = layers_[level];
  layer.resize(layerBytes(levels_[level], chunk_voxels_, fill_.size()));
  const bool is_one_byte =
      std::all_of(fill_.begin(), fill_.end(), [&](std::byte b) { return b == fill_.front(); });
  if (is_one_byte)
    std::fill(layer.begin(), layer.end(), fill_.front());
  else
    for (size_t i = 0; i < layer.size(); i += fill_.size())
      std::memcpy(layer.data() + i, fill_.data(), fill_.size());
  if (keepsSpreads(how_))
    spreads_[level].assign(
        layerBytes(levels_[level], chunk_voxels_, bytesPerVoxel(spreadType(type_))), std::byte{0});
}

Box3 LevelMaker::layerAt(size_t level, int64_t z) const {
  const LevelShape& shape = levels_[level];
  const int64_t first = z / shape.step.z / chunk_voxels_ * chunk_voxels_;
  return {{0, 0, first},
          {shape.dims.x, shape.dims.y, std::min(first + chunk_voxels_, shape.dims.z)}};
}

void LevelMaker::add(const Box3& box, const std::byte* voxels, int64_t row_stride,
                     int64_t plane_stride) {
  visitVoxelType(type_, [&](auto tag) {
    using T = decltype(tag);
    addOf<T>(box, reinterpret_cast<const T*>(voxels), row_stride, plane_stride);
  });
}

namespace {

// spreadType() of T.
template <class T>
struct SpreadOf {
  using Type =
      std::conditional_t<std::is_integral_v<T> && sizeof(T) <= 2,
                         std::make_unsigned_t<std::conditional_t<std::is_integral_v<T>, T, int>>,
                         float>;
};

// What squares of a cube are measured from: the value of its first voxel.
template <class T>
double originOf(const T* voxels) {
  if constexpr (isNarrow<T>) return 0;  // sums are exact, whatever the cube
  const auto value = static_cast<double>(*voxels);
  return std::isfinite(value) ? value : 0;
}

}  // namespace

namespace {

// A step from a level to the next is 1 or 2 along each axis, and so a shift of the index by 0 or 1.

// Blocks into those of the next level.
void gatherCoarser(Blocks& finer, Vec3i step, Downsample how, Blocks& coarser) {
  for (int64_t z = 0; z < finer.size.z; ++z)
    for (int64_t y = 0; y < finer.size.y; ++y) {
      const Gathered* const from = &finer.at({0, y, z});
      Gathered* const to = &coarser.at({0, y >> (step.y - 1), z >> (step.z - 1)});
      for (int64_t x = 0; x < finer.size.x; ++x) gather(to[x >> (step.x - 1)], from[x], how);
    }
}

// The finest voxels of a cube into the blocks of the first level.
template <class T>
void gatherFirst(Vec3i size, Vec3i step, const T* voxels, int64_t row_stride, int64_t plane_stride,
                 double origin, Downsample how, Blocks& blocks) {
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      Gathered* const row = &blocks.at({0, y >> (step.y - 1), z >> (step.z - 1)});
      const T* const from = voxels + z * plane_stride + y * row_stride;
      for (int64_t x = 0; x < size.x; ++x)
        if (isNumber(from[x])) {
          const auto value = static_cast<double>(from[x]);
          const double away = value - origin;
          gather(row[x >> (step.x - 1)], {value, away * away, 1}, how);
        }
    }
}

// The same sums of narrow integers, row by row of blocks in whole numbers, which compilers turn
// into vector code. Doubles hold them exactly, so that the results are the same.
template <class T>
void gatherSums(Vec3i size, Vec3i step, const T* voxels, int64_t row_stride, int64_t plane_stride,
                double origin, Blocks& blocks) {
  using Square = std::conditional_t<sizeof(T) == 1, uint32_t, uint64_t>;  // eight squares at most
  const auto columns = static_cast<size_t>(blocks.size.x);
  std::vector<int32_t> sums(columns);
  std::vector<Square> squares(columns);
  for (int64_t z = 0; z < blocks.size.z; ++z)
    for (int64_t y = 0; y < blocks.size.y; ++y) {
      std::fill(sums.begin(), sums.end(), 0);
      std::fill(squares.begin(), squares.end(), Square{0});
      int32_t* const __restrict sum = sums.data();
      Square* const __restrict square = squares.data();
      const Vec3i lo{0, y * step.y, z * step.z};
      const Vec3i hi = min(lo + step, size);
      for (int64_t pz = lo.z; pz < hi.z; ++pz)
        for (int64_t py = lo.y; py < hi.y; ++py) {
          const T* const __restrict row = voxels + pz * plane_stride + py * row_stride;
          const auto add = [&](size_t column, T value) {
            const auto wide = static_cast<uint32_t>(static_cast<int32_t>(value));
            sum[column] += value;
            square[column] += Square{wide * wide};
          };
          const auto pairs = static_cast<size_t>(size.x / step.x);
          if (step.x == 1) {
            for (size_t x = 0; x < pairs; ++x) add(x, row[x]);
            continue;
          }
          for (size_t x = 0; x < pairs; ++x) {
            const int32_t a = row[2 * x], b = row[2 * x + 1];
            sum[x] += a + b;
            // A square of 16 bits fits into 32 without a sign.
            square[x] += Square{static_cast<uint32_t>(a) * static_cast<uint32_t>(a)} +
                         Square{static_cast<uint32_t>(b) * static_cast<uint32_t>(b)};
          }
          if (size.x % 2 != 0) add(pairs, row[size.x - 1]);
        }
      Gathered* const out = &blocks.at({0, y, z});
      const auto rows = (hi.z - lo.z) * (hi.y - lo.y);
      for (size_t x = 0; x < columns; ++x) {
        const auto first = static_cast<int64_t>(x) * step.x;
        const int64_t count = rows * (std::min(first + step.x, size.x) - first);
        const auto value = static_cast<double>(sum[x]);
        out[x] = {value,
                  static_cast<double>(square[x]) - 2 * origin * value +
                      origin * origin * static_cast<double>(count),
                  static_cast<uint32_t>(count)};
      }
    }
}

}  // namespace

template <class T>
void LevelMaker::addOf(const Box3& box, const T* voxels, int64_t row_stride, int64_t plane_stride) {
  const Vec3i size = box.size();
  const auto finest = [&](Vec3i p) { return voxels[p.z * plane_stride + p.y * row_stride + p.x]; };
  const double origin = originOf(voxels);
  std::unique_ptr<Scratch> scratch;
  {
    const MutexLock lock(mutex_);
    if (!idle_.empty()) {
      scratch = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (scratch == nullptr) scratch = std::make_unique<Scratch>();
  Blocks &finer = scratch->finer, &coarser = scratch->coarser;
  Vec3i finer_step{1, 1, 1};
  std::vector<T> values;
  for (size_t i = 0; i < levels_.size(); ++i) {
    const LevelShape& level = levels_[i];
    const Vec3i blocks = roundedUp(size, level.step), first = box.lo / level.step;
    const Box3 layer = layerAt(i, box.lo.z);
    T* const to = reinterpret_cast<T*>(layers_[i].data());
    const auto placeOf = [&](Vec3i p) {
      const Vec3i at = first + p - layer.lo;
      return (at.z * level.dims.y + at.y) * level.dims.x + at.x;
    };
    const auto put = [&](Vec3i p, T value) { to[placeOf(p)] = value; };
    if (how_ == Downsample::kMode) {
      eachVoxel(blocks, [&](Vec3i p) {
        const Vec3i lo = p * level.step, hi = min(lo + level.step, size);
        values.clear();
        eachVoxel(hi - lo, [&](Vec3i q) {
          if (const T value = finest(lo + q); isNumber(value)) values.push_back(value);
        });
        put(p, modeOf(values));
      });
      continue;
    }
    // Gathered from the blocks of the level before, whose sums are not rounded.
    makeEmpty(coarser, blocks);
    const Vec3i step = level.step / finer_step;
    if (i == 0) {
      if constexpr (isNarrow<T>) {
        if (how_ == Downsample::kMean)
          gatherSums(size, level.step, voxels, row_stride, plane_stride, origin, coarser);
        else
          gatherFirst(size, level.step, voxels, row_stride, plane_stride, origin, how_, coarser);
      } else {
        gatherFirst(size, level.step, voxels, row_stride, plane_stride, origin, how_, coarser);
      }
    } else {
      gatherCoarser(finer, step, how_, coarser);
    }
    using Spread = typename SpreadOf<T>::Type;
    auto* const spreads = reinterpret_cast<Spread*>(spreads_[i].data());
    for (int64_t z = 0; z < blocks.z; ++z)
      for (int64_t y = 0; y < blocks.y; ++y) {
        const int64_t at = placeOf({0, y, z});
        const Gathered* const row = &coarser.at({0, y, z});
        for (int64_t x = 0; x < blocks.x; ++x) to[at + x] = resultOf<T>(row[x], how_);
        if (!keepsSpreads(how_)) continue;
        for (int64_t x = 0; x < blocks.x; ++x) spreads[at + x] = spreadOf<Spread>(row[x], origin);
      }
    std::swap(finer, coarser);
    finer_step = level.step;
  }
  const MutexLock lock(mutex_);
  idle_.push_back(std::move(scratch));
}

void makeLevelRegion(VolumeSource& finest, int64_t time, const LevelShape& level, const Box3& box,
                     std::span<std::byte> voxels, std::span<std::byte> spreads) {
  const VolumeLayout& layout = finest.layout();
  const Vec3i from = box.lo * level.step, size = min(box.hi * level.step, layout.dims) - from;
  const int64_t side = std::max({level.step.x, level.step.y, level.step.z});
  VolumeLayout part = layout;
  part.dims = size;
  const size_t voxel = bytesPerVoxel(layout.type);
  const std::vector<std::byte> fill(voxel);
  // With the levels between, since each is gathered from the one before.
  std::vector<LevelShape> levels;
  for (Vec3i step{1, 1, 1}; step != level.step;) {
    step = min(step * 2, level.step);
    levels.push_back({roundedUp(size, step), step});
  }
  const size_t last = levels.size() - 1;
  LevelMaker maker(part, side, std::move(levels), Downsample::kMean, fill);
  std::vector<std::byte> cube(static_cast<size_t>(side * side * side) * voxel);
  const auto copyLayer = [&](const Box3& layer, const std::byte* made, std::span<std::byte> to) {
    if (to.empty()) return;
    const size_t plane = to.size() / static_cast<size_t>(box.size().z);
    std::memcpy(to.data() + plane * static_cast<size_t>(layer.lo.z), made,
                plane * static_cast<size_t>(layer.size().z));
  };
  for (int64_t z = 0; z < size.z; z += side) {
    for (int64_t y = 0; y < size.y; y += side)
      for (int64_t x = 0; x < size.x; x += side) {
        const Vec3i lo{x, y, z};
        const Box3 own = intersect({lo, lo + Vec3i{side, side, side}}, boxOf(size));
        finest.readRegion(time, translate(own, from),
                          std::span(cube).first(static_cast<size_t>(own.count()) * voxel));
        maker.add(own, cube.data(), own.size().x, own.size().x * own.size().y);
      }
    const Box3 layer = maker.layerAt(last, z);
    const int64_t end = std::min(z + side, size.z);
    if (end < size.z && end % (side * level.step.z) != 0) continue;
    copyLayer(layer, maker.layerVoxels(last), voxels);
    copyLayer(layer, maker.layerSpreads(last), spreads);
    maker.clearLayer(last);
  }
}

}  // namespace sluice
