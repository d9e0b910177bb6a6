#include "src/visibility/plenoptic/visibility_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "src/base/error.h"
#include "src/base/values/corners.h"

namespace sluice {
namespace {

// The relative error that float arithmetic may add to a ray's sum.
constexpr double kSumDoubt = 1e-3;

// Changed parts may take one part in so many of what tiles may keep.
constexpr uint64_t kKeptShare = 8;

// A place further off than any picture reaches.
constexpr int kFarPixels = 1 << 28;

float limitOf(const EstimateView& view, const EstimateOptions& options) {
  SLUICE_CHECK(options.opacity_threshold > 0);
  if (options.opacity_threshold >= 1) return std::numeric_limits<float>::infinity();
  const double depth = -std::log1p(-options.opacity_threshold);
  // A perspective view's slices are further apart away from the middle: it accumulates more.
  return static_cast<float>(depth * (1 + kSumDoubt) / view.slice_length);
}

double along(const std::array<double, 4>& row, Vec3d p) {
  return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
}

}  // namespace

EstimateView estimateView(const FrameSetup& setup, Vec3d eye_or_direction) {
  return {setup.size,
          setup.rays,
          setup.clip_from_index,
          setup.projection == Projection::kOrtho,
          eye_or_direction,
          static_cast<double>(setup.first_slice),
          setup.depth_step,
          setup.slice_length,
          {setup.tan_half_x, setup.tan_half_y}};
}

VisibilityEstimate::VisibilityEstimate(SeriesOpacityPtr series, const EstimateView& view,
                                       const EstimateOptions& options)
    : series_(std::move(series)),
      view_(view),
      options_(options),
      limit_(limitOf(view, options)),
      reached_in_(static_cast<size_t>(series_->blockCount())),
      functions_(reached_in_.size(), -1),
      changes_(reached_in_.size()) {
  for (size_t i = 0; i < extinction_.size(); ++i)
    extinction_[i] =
        static_cast<float>(options.exponent) * unpackExtinction(static_cast<uint8_t>(i));
  for (size_t i = 0; i < 4; ++i) {
    pixel_from_index_[0][i] = view.clip_from_index[0][i] * 0.5 * view.size.width;
    pixel_from_index_[1][i] = view.clip_from_index[1][i] * 0.5 * view.size.height;
  }
  if (view.parallel) {
    pixel_from_index_[0][3] += 0.5 * view.size.width;
    pixel_from_index_[1][3] += 0.5 * view.size.height;
  }
  if (view.parallel) {
    // Slices are parallel planes, so that their number is linear in the position.
    const RayGrid& rays = view.rays;
    const Vec3d across = cross(rays.origin_dx, rays.origin_dy);
    const Vec3d way = across * (1 / dot(rays.step0, across));
    slice_from_index_ = {way.x, way.y, way.z, -dot(way, rays.origin0)};
  }
  placeBlocks();
  makeTiles();
}

bool VisibilityEstimate::isShown(const Box3& cells) const {
  for (const Box3& shown : options_.shown)
    if (!shown.contains(cells)) return false;
  for (const ClipPlane& plane : options_.clip_planes)
    for (int i = 0; i < 8; ++i)
      if (dot(plane.normal, toDouble(cornerOf(cells, i))) > plane.offset) return false;
  return true;
}

VisibilityEstimate::Rect VisibilityEstimate::footprintOf(const Box3& cells) const {
  const Rect all{0, 0, view_.size.width, view_.size.height};
  // Centres of pixels count; one more on each side covers rounding.
  const auto pixel = [](double v, int most) {
    return std::clamp(static_cast<int>(v + kFarPixels) - kFarPixels, 0, most);
  };
  if (view_.parallel) {
    // The bounds of a box are its middle's place and the sums of its half sides' contributions.
    const Vec3d middle = (toDouble(cells.lo) + toDouble(cells.hi)) * 0.5;
    const Vec3d half = toDouble(cells.size()) * 0.5;
    std::array<double, 2> at{}, reach{};
    for (size_t i = 0; i < 2; ++i) {
      const auto& row = pixel_from_index_[i];
      at[i] = along(row, middle);
      reach[i] = std::abs(row[0]) * half.x + std::abs(row[1]) * half.y + std::abs(row[2]) * half.z;
      at[i] = std::clamp(at[i], -kFarPixels / 2.0, kFarPixels / 2.0);
      reach[i] = std::min(reach[i], kFarPixels / 4.0);
    }
    return {pixel(at[0] - reach[0] - 1, all.x1), pixel(at[1] - reach[1] - 1, all.y1),
            pixel(at[0] + reach[0] + 2, all.x1), pixel(at[1] + reach[1] + 2, all.y1)};
  }
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (int i = 0; i < 8; ++i) {
    const Vec3d at = toDouble(cornerOf(cells, i));
    const double w = along(view_.clip_from_index[2], at);
    if (!(w > 1e-6 * view_.depth_step)) return all;  // at the side of the eye, or behind it
    const double x = along(pixel_from_index_[0], at) / w + 0.5 * all.x1;
    const double y = along(pixel_from_index_[1], at) / w + 0.5 * all.y1;
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  const double far = kFarPixels / 2.0;
  return {pixel(std::max(x0 - 1, -far), all.x1), pixel(std::max(y0 - 1, -far), all.y1),
          pixel(std::min(x1 + 2, far), all.x1), pixel(std::min(y1 + 2, far), all.y1)};
}

// Boxes of a row of `count` boxes, `side` cells each, the first at `offset`: those first that can
// hide others.
std::vector<int64_t> VisibilityEstimate::axisOrder(int axis, int64_t first, int64_t count,
                                                   int64_t side, int64_t offset) const {
  std::vector<int64_t> order;
  for (int64_t i = 0; i < count; ++i) order.push_back(first + i);
  if (view_.parallel) {
    if (view_.eye[axis] < 0) std::reverse(order.begin(), order.end());
    return order;
  }
  const double eye = (view_.eye[axis] - static_cast<double>(offset)) / static_cast<double>(side);
  std::sort(order.begin(), order.end(), [&](int64_t a, int64_t b) {
    return std::abs(static_cast<double>(a) + 0.5 - eye) <
           std::abs(static_cast<double>(b) + 0.5 - eye);
  });
  return order;
}

void VisibilityEstimate::placeDirections(int64_t block, Place& place) const {
  const Box3 cells = series_->cellsOf(block);
  const PartGrid grid = series_->partsOf(block);
  const DirectionGrid& directions = series_->directions;
  if (view_.parallel) {
    const int cell = directions.cellOf(view_.eye);
    const int axis = directions.slopesOf(cell).axis;
    const double step = std::abs(view_.rays.step0[axis]);
    place.directions = {cell};
    // The table's ratio holds for samples at distances of up to a voxel (opacity_function.h).
    place.has_ratio = step > 0 && step <= 1 + 1e-9;
    place.least_slices = static_cast<float>(leastDepthVox(grid, axis) / step);
    return;
  }
  place.directions = directions.cellsToward(view_.eye, toDouble(cells.lo), toDouble(cells.hi));
  for (const int cell : place.directions) {
    const int axis = directions.slopesOf(cell).axis;
    // Cells of the axis from slice to slice: over a box its extremes are at the corners.
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (int i = 0; i < 8; ++i) {
      const Vec3d at = toDouble(cornerOf(cells, i));
      const double depth = along(view_.clip_from_index[2], at);
      const double step = depth > 0 ? (at[axis] - view_.eye[axis]) / depth * view_.depth_step : 0;
      least = std::min(least, step);
      most = std::max(most, step);
    }
    const bool crosses = least <= 0 && most >= 0;
    const double slowest = crosses ? 0 : std::min(std::abs(least), std::abs(most));
    const double fastest = std::max(std::abs(least), std::abs(most));
    place.has_ratio = place.has_ratio && slowest > 0 && fastest <= 1 + 1e-9;
    if (slowest > 0)
      place.least_slices =
          std::max(place.least_slices, static_cast<float>(leastDepthVox(grid, axis) / slowest));
  }
}

void VisibilityEstimate::placeBlocks() {
  const Vec3i grid = series_->grid;
  places_.resize(static_cast<size_t>(series_->blockCount()));
  std::array<std::vector<int64_t>, 3> order;
  for (int a = 0; a < 3; ++a)
    order[static_cast<size_t>(a)] = axisOrder(a, 0, grid[a], series_->block_cells, 0);
  for (const int64_t z : order[2])
    for (const int64_t y : order[1])
      for (const int64_t x : order[0]) {
        const int64_t block = (z * grid.y + y) * grid.x + x;
        Place& place = places_[static_cast<size_t>(block)];
        place.rank = static_cast<uint32_t>(order_.size());
        order_.push_back(static_cast<uint32_t>(block));
        const Box3 cells = series_->cellsOf(block);
        place.footprint = footprintOf(cells);
        place.whole = isShown(cells);
        placeDirections(block, place);
      }
}

void VisibilityEstimate::makeTiles() {
  tiles_x_ = (view_.size.width + kTileSide - 1) / kTileSide;
  tiles_y_ = (view_.size.height + kTileSide - 1) / kTileSide;
  for (int y = 0; y < tiles_y_; ++y)
    for (int x = 0; x < tiles_x_; ++x) {
      Tile& tile = tiles_.emplace_back();
      tile.pixels = {x * kTileSide, y * kTileSide, std::min((x + 1) * kTileSide, view_.size.width),
                     std::min((y + 1) * kTileSide, view_.size.height)};
    }
  for (const uint32_t block : order_) {
    const Rect& at = places_[block].footprint;
    if (at.x0 >= at.x1 || at.y0 >= at.y1) continue;
    for (int y = at.y0 / kTileSide; y <= (at.y1 - 1) / kTileSide; ++y)
      for (int x = at.x0 / kTileSide; x <= (at.x1 - 1) / kTileSide; ++x)
        if (const int tile = y * tiles_x_ + x; tile % options_.tile_stride == options_.first_tile)
          tiles_[static_cast<size_t>(tile)].blocks.push_back(block);
  }
  uint64_t kept_bytes = 0;
  for (Tile& tile : tiles_) {
    tile.reached.assign(tile.blocks.size(), false);
    kept_bytes += tile.blocks.size() * sizeof(Added);
    if (kept_bytes <= options_.most_kept_bytes) tile.added.resize(tile.blocks.size());
    const Rect& p = tile.pixels;
    if (!tile.blocks.empty()) all_pixels_ += static_cast<int64_t>(p.x1 - p.x0) * (p.y1 - p.y0);
  }
}

// The first slice that a sample in the box may have; of a perspective view not known.
float VisibilityEstimate::nearSlice(const Box3& cells) const {
  constexpr float kBeforeAll = -1e30F;
  if (!view_.parallel) return kBeforeAll;
  const auto& row = slice_from_index_;
  const Vec3d half = toDouble(cells.size()) * 0.5;
  const double reach =
      std::abs(row[0]) * half.x + std::abs(row[1]) * half.y + std::abs(row[2]) * half.z;
  return static_cast<float>(along(row, toDouble(cells.lo) + half) - reach);
}

// The parts that hide more or less when function `now` stands for the block instead of `before`.
std::vector<VisibilityEstimate::ChangedPart> VisibilityEstimate::changedParts(int64_t block,
                                                                              int32_t before,
                                                                              int32_t now,
                                                                              size_t most) const {
  const OpacityFunction& a = series_->functions[static_cast<size_t>(before)];
  const OpacityFunction& b = series_->functions[static_cast<size_t>(now)];
  const Place& place = places_[static_cast<size_t>(block)];
  const Box3 cells = series_->cellsOf(block);
  const float ratio_a = ratioOf(a, place), ratio_b = ratioOf(b, place);
  const bool as_wholes = options_.form != OpacityForm::kOpof;
  const bool has_table =
      as_wholes || ratio_a > extinction_[a.floor] || ratio_b > extinction_[b.floor];
  const ChangedPart whole{place.footprint, -std::numeric_limits<float>::infinity()};
  // The table changed, and with it every ray through the block.
  if (has_table && (ratio_a != ratio_b || a.floor != b.floor)) return {whole};
  std::vector<ChangedPart> changed;
  if (as_wholes) return changed;
  const PartGrid grid = series_->partsOf(block);
  const Vec3i count = grid.count();
  DetailReader in_a(a.parts, a.detail), in_b(b.parts, b.detail);
  const auto levelsOf = [](const OpacityFunction& of, DetailReader& in) {
    return of.parts.empty() ? PartLevels::of(of.floor) : in.next();
  };
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y)
      for (int64_t x = 0; x < count.x; ++x) {
        if (levelsOf(a, in_a) == levelsOf(b, in_b)) continue;
        if (changed.size() >= most) return {whole};
        const Box3 part = translate(grid.cellsOf({x, y, z}), cells.lo);
        changed.push_back({footprintOf(part), nearSlice(part)});
      }
  return changed;
}

std::vector<VisibilityEstimate::Task> VisibilityEstimate::allTiles(int64_t step) {
  changed_blocks_ = 0;
  for (int64_t block = 0; block < series_->blockCount(); ++block) {
    int32_t& function = functions_[static_cast<size_t>(block)];
    const int32_t now = series_->functionAt(block, step);
    changed_blocks_ += now != function ? 1 : 0;
    function = now;
  }
  std::vector<Task> tasks;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    if (tiles_[i].blocks.empty()) continue;
    tasks.push_back({i});
    for (std::unique_ptr<Added>& added : tiles_[i].added) added.reset();
  }
  return tasks;
}

// Finds the changes to `step`, and their places.
void VisibilityEstimate::takeChanges(int64_t step, WorkerPool& pool) {
  for (const int64_t block : changed_) changes_[static_cast<size_t>(block)] = {};
  changed_ = series_->tree->changedBetween(step_, step);
  changed_blocks_ = static_cast<int64_t>(changed_.size());
  const uint64_t most_parts = options_.most_kept_bytes / kKeptShare / sizeof(ChangedPart);
  const size_t most = most_parts / std::max<size_t>(1, changed_.size());
  pool.parallelFor(changed_blocks_, [&](int64_t i) {
    const int64_t block = changed_[static_cast<size_t>(i)];
    int32_t& function = functions_[static_cast<size_t>(block)];
    Change& change = changes_[static_cast<size_t>(block)];
    change.before = std::exchange(function, series_->functionAt(block, step));
    if (change.before != function)
      change.parts = changedParts(block, change.before, function, most);
  });
}

std::vector<VisibilityEstimate::Task> VisibilityEstimate::affectedTiles(int64_t step,
                                                                        WorkerPool& pool) {
  takeChanges(step, pool);
  std::vector<Task> of_tile(tiles_.size());
  for (const int64_t block : changed_) {
    const Place& place = places_[static_cast<size_t>(block)];
    const Rect& at = place.footprint;
    if (at.x0 >= at.x1 || at.y0 >= at.y1) continue;
    for (int y = at.y0 / kTileSide; y <= (at.y1 - 1) / kTileSide; ++y)
      for (int x = at.x0 / kTileSide; x <= (at.x1 - 1) / kTileSide; ++x) {
        const int index = y * tiles_x_ + x;
        const auto i = static_cast<size_t>(index);
        if (tiles_[i].blocks.empty()) continue;
        const Tile& tile = tiles_[i];
        const auto found =
            std::lower_bound(tile.blocks.begin(), tile.blocks.end(), place.rank,
                             [&](uint32_t of, uint32_t than) { return places_[of].rank < than; });
        const auto in_tile = static_cast<size_t>(found - tile.blocks.begin());
        const bool is_kept = !tile.added.empty() && tile.added[in_tile] != nullptr;
        if (tile.reached[in_tile] || is_kept) of_tile[i].changed.push_back(in_tile);
      }
  }
  std::vector<Task> tasks;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    if (of_tile[i].changed.empty()) continue;
    of_tile[i].tile = i;
    tasks.push_back(std::move(of_tile[i]));
  }
  return tasks;
}

uint64_t VisibilityEstimate::mostBytes(const SeriesOpacity& series, PictureSize size,
                                       uint64_t most_kept_bytes, int threads) {
  const auto blocks = static_cast<uint64_t>(series.blockCount());
  constexpr uint64_t kDirections = 64;  // a small vector
  const uint64_t of_blocks = blocks * (sizeof(Place) + kDirections + sizeof(Change) +
                                       2 * sizeof(int64_t) + 3 * sizeof(uint32_t));
  const int64_t across = std::max({series.grid.x, series.grid.y, series.grid.z});
  const auto tiles = static_cast<uint64_t>((size.width + kTileSide - 1) / kTileSide) *
                     static_cast<uint64_t>((size.height + kTileSide - 1) / kTileSide);
  // A tile meets the blocks along a ray, in as many columns as are as wide as it, with the pixels
  // that bounds of blocks have to spare.
  const double columns =
      static_cast<double>((kTileSide + 3) * across) / std::min(size.width, size.height) + 1;
  const auto listed = static_cast<uint64_t>(columns * columns * static_cast<double>(3 * across));
  constexpr uint64_t kListed = 16;  // in the tile's list, whether reached, in that of changes
  const auto parts = static_cast<size_t>(volume(series.partsOf(0).count()));
  return of_blocks + tiles * (sizeof(Tile) + sizeof(Task) + listed * kListed) + most_kept_bytes +
         2 * most_kept_bytes / kKeptShare +
         static_cast<uint64_t>(threads) * UnpackedParts::mostBytes(parts);
}

void VisibilityEstimate::setStep(int64_t step, WorkerPool& pool, bool from_scratch) {
  SLUICE_CHECK(step >= 0 && step < series_->steps);
  try {
    estimateStep(step, pool, from_scratch);
  } catch (...) {
    step_ = -1;  // some blocks and tiles are not of this step: the next call looks at all of them
    throw;
  }
}

void VisibilityEstimate::estimateStep(int64_t step, WorkerPool& pool, bool from_scratch) {
  std::vector<Task> tasks = step_ < 0 || from_scratch ? allTiles(step) : affectedTiles(step, pool);
  step_ = step;
  // The answers of these tiles are taken back, and counted anew when they have been looked at.
  const auto count = [&](int32_t by) {
    for (const Task& task : tasks) {
      const Tile& tile = tiles_[task.tile];
      for (size_t k = 0; k < tile.blocks.size(); ++k)
        if (tile.reached[k]) reached_in_[tile.blocks[k]] += by;
    }
  };
  count(-1);
  try {
    pool.parallelFor(static_cast<int64_t>(tasks.size()),
                     [&](int64_t i) { estimateTile(tasks[static_cast<size_t>(i)]); });
  } catch (...) {
    count(1);
    throw;
  }
  count(1);
  pixels_checked_ = 0;
  for (const Task& task : tasks) {
    const Rect& p = tiles_[task.tile].pixels;
    if (task.is_affected) pixels_checked_ += static_cast<int64_t>(p.x1 - p.x0) * (p.y1 - p.y0);
  }
}

}  // namespace sluice
