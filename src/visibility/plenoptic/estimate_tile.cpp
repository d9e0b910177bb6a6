// A tile of the visibility estimate: blocks front to back against its opacity buffer.
#include <algorithm>
#include <cmath>
#include <limits>

#include "src/visibility/plenoptic/ray_rows.h"
#include "src/visibility/plenoptic/visibility_estimate.h"

namespace sluice {
namespace {

constexpr int kSide = VisibilityEstimate::kTileSide;
constexpr size_t kTilePixels = static_cast<size_t>(kSide) * kSide;
static_assert(kSide == TileRays::kSide);

// How far from a block a sample may be, in voxels, that a device's arithmetic puts into it.
constexpr double kPlaceDoubt = 1e-3;

// No slice of a block is known to be clear.
constexpr int32_t kNoneClear = -(1 << 30);

// All slices before this one are in front of `near`.
int32_t beforeSlice(float near) {
  return near > -1e9F ? static_cast<int32_t>(std::floor(near)) - 1 : kNoneClear;
}

Vec3d cube(double side) {
  return {side, side, side};
}

}  // namespace

std::unique_ptr<UnpackedParts> VisibilityEstimate::takeUnpacked() {
  const MutexLock lock(unpacked_mutex_);
  if (unpacked_.empty()) return std::make_unique<UnpackedParts>();
  auto taken = std::move(unpacked_.back());
  unpacked_.pop_back();
  return taken;
}

void VisibilityEstimate::giveBack(std::unique_ptr<UnpackedParts> unpacked) {
  const MutexLock lock(unpacked_mutex_);
  unpacked_.push_back(std::move(unpacked));
}

// The work space of a thread.
class VisibilityEstimate::TileWork {
 public:
  TileWork(const VisibilityEstimate& of, const Tile& tile, UnpackedParts& unpacked)
      : of_(of),
        unpacked_(unpacked),
        tile_(tile.pixels),
        width_(tile_.x1 - tile_.x0),
        height_(tile_.y1 - tile_.y0) {
    rays_.set(of.view_.rays, of.view_.parallel, of.view_.first_slice, tile_.x0, tile_.y0);
    is_open_.fill(true);
  }

  // Whether a ray that is not opaque has a sample in the block.
  bool reaches(uint32_t block) {
    const Box3 cells = series().cellsOf(block);
    setPixels(of_.places_[block].footprint);
    const auto planes = rays_.planesOf(toDouble(cells.lo) - cube(kPlaceDoubt),
                                       toDouble(cells.hi) + cube(kPlaceDoubt));
    for (int y = y0_; y < y1_; ++y) {
      if (!is_open_[static_cast<size_t>(y)]) continue;
      rays_.stretches(planes, y, x0_, x1_, entry_, exit_);
      // A sample that may lie on either side of a face counts for both boxes, and hides in neither.
      samplesOf(entry_, exit_, x0_, x1_, -kSliceDoubt, first_, count_);
      const float* sum = sum_.data() + y * kSide;
      bool reached = false;
      for (int x = x0_; x < x1_; ++x)
        reached |= (count_[static_cast<size_t>(x)] > 0) & (sum[x] < of_.limit_);
      if (reached) return true;
    }
    return false;
  }

  // Adds the block along each ray. `kept`: values known from before, which are completed; nullptr:
  // none are kept.
  void add(uint32_t block, const OpacityFunction& function, Added* kept) {
    const Place& place = of_.places_[block];
    const bool whole = of_.options_.form != OpacityForm::kOpof;
    if (function.empty() || (whole && !place.whole)) return;
    setPixels(place.footprint);
    is_set_ = false;
    batch_.reset();
    for (int y = y0_; y < y1_; ++y) {
      if (!is_open_[static_cast<size_t>(y)]) continue;
      const size_t row = static_cast<size_t>(y) * kSide;
      if (findKnown(kept, row)) continue;
      if (!is_set_) setBlock(block, function);
      addRow(place, y, kept);
    }
    if (batch_) batch_->finish();
    for (int y = y0_; y < y1_; ++y)
      // Rows are summed after the batch, which follows rays of several rows together.
      if (is_open_[static_cast<size_t>(y)]) sumRow(kept, y);
  }

  bool isOpaque() const {
    return std::none_of(is_open_.begin(), is_open_.begin() + height_,
                        [](bool open) { return open; });
  }

 private:
  void setPixels(const Rect& footprint) {
    x0_ = std::max(footprint.x0, tile_.x0) - tile_.x0;
    x1_ = std::min(footprint.x1, tile_.x1) - tile_.x0;
    y0_ = std::max(footprint.y0, tile_.y0) - tile_.y0;
    y1_ = std::min(footprint.y1, tile_.y1) - tile_.y0;
  }

  // Sets the extinctions of the block's parts; parts that may not show get none.
  void setParts(uint32_t block, const OpacityFunction& function) {
    const PartGrid grid = series().partsOf(block);
    const Vec3i count = grid.count();
    cube_cells_ = static_cast<double>(grid.side) / kDetail;
    for (int a = 0; a < 3; ++a)
      part_count_[static_cast<size_t>(a)] = static_cast<int32_t>(count[a]);
    const auto parts = static_cast<size_t>(volume(count));
    parts_ = &unpacked_.of(of_.functions_[block], function, parts, of_.extinction_);
    if (of_.places_[block].whole) return;
    shown_parts_ = *parts_;
    parts_ = &shown_parts_;
    const Vec3i lo = series().cellsOf(block).lo;
    for (size_t i = 0; i < parts; ++i) {
      const auto at = static_cast<int64_t>(i);
      const Vec3i part{at % count.x, at / count.x % count.y, at / (count.x * count.y)};
      if (of_.isShown(translate(grid.cellsOf(part), lo))) continue;
      std::fill_n(shown_parts_.extinction.begin() + static_cast<ptrdiff_t>(4 * i), 4, 0.0F);
    }
  }

  // Finds the rays of the row whose kept sums suffice: they are complete, or so great that the ray
  // is opaque. Returns whether that is all of them.
  bool findKnown(const Added* kept, size_t row) {
    bool all = true;
    for (size_t i = row + first_x(); i < row + end_x(); ++i) {
      // The sign marks a lower bound, so that a sum of 0 may be one, too.
      const float along = kept != nullptr ? kept->along[i] : -0.0F;
      is_known_[i] = !std::signbit(along) | (sum_[i] - along >= of_.limit_);
      added_[i] = std::abs(along);
      by_table_[i] = 0;
      all &= is_known_[i];
    }
    return all;
  }

  // Adds the sums of the row's rays, and keeps them. A ray that became opaque may not have been
  // followed to its end.
  void sumRow(Added* kept, int y) {
    const size_t row = static_cast<size_t>(y) * kSide;
    for (size_t i = row + first_x(); i < row + end_x(); ++i) {
      // Both the parts and the table are lower bounds, so that the greater one holds.
      added_[i] = std::max(added_[i], by_table_[i]);
      if (kept != nullptr && !is_known_[i]) {
        const bool is_cut = has_parts_ && taken_[i] < counts_[i];
        kept->along[i] = is_cut || sum_[i] + added_[i] >= of_.limit_ ? -added_[i] : added_[i];
        kept->end[i] = is_cut ? static_cast<float>(firsts_[i] + taken_[i])
                              : std::numeric_limits<float>::infinity();
        kept->clear[i] = has_parts_ ? firsts_[i] + clear_[i] : kNoneClear;
      }
      sum_[i] += added_[i];
    }
    float least = of_.limit_;
    for (size_t i = row; i < row + static_cast<size_t>(width_); ++i)
      least = std::min(least, sum_[i]);
    is_open_[static_cast<size_t>(y)] = least < of_.limit_;
  }

  size_t first_x() const { return static_cast<size_t>(x0_); }
  size_t end_x() const { return static_cast<size_t>(x1_); }

  void setBlock(uint32_t block, const OpacityFunction& function) {
    const Place& place = of_.places_[block];
    whole_ = of_.options_.form != OpacityForm::kOpof;
    floor_ = of_.extinction_[function.floor];
    ratio_ = place.whole ? of_.ratioOf(function, place) : 0;
    has_parts_ = !whole_ && (!function.parts.empty() || !place.whole);
    if (has_parts_) {
      setParts(block, function);
      batch_.emplace(PartValues{parts_->cubes.data(), parts_->extinction.data(), part_count_},
                     SampleBatch::Results{added_.data(), taken_.data(), clear_.data()});
    }
    const Box3 cells = series().cellsOf(block);
    lo_ = toDouble(cells.lo);
    planes_ = rays_.planesOf(lo_, toDouble(cells.hi));
    if (whole_) setWhole(cells, place, floor_, ratio_);
    is_set_ = true;
  }

  void addRow(const Place& place, int y, const Added* kept) {
    const size_t row = static_cast<size_t>(y) * kSide;
    rays_.stretches(planes_, y, x0_, x1_, entry_, exit_);
    if (whole_) {
      addWhole(place, row);
      return;
    }
    samplesOf(entry_, exit_, x0_, x1_, kSliceDoubt, first_, count_);
    if (has_parts_)
      addParts(y, kept);
    else
      for (size_t x = first_x(); x < end_x(); ++x)
        if (!is_known_[row + x]) added_[row + x] = floor_ * static_cast<float>(count_[x]);
    if (ratio_ > floor_) noteTable(place, row);
  }

  void addParts(int y, const Added* kept) {
    rays_.positions(lo_, 1 / cube_cells_, y, x0_, x1_, first_, positions_);
    for (size_t x = first_x(), i = static_cast<size_t>(y) * kSide + x; x < end_x(); ++x, ++i) {
      if (is_known_[i]) continue;
      added_[i] = 0;
      taken_[i] = 0;
      clear_[i] = 0;
      firsts_[i] = first_[x];
      counts_[i] = count_[x];
      const float room = of_.limit_ - sum_[i];
      if (!(room > 0) || count_[x] == 0) continue;
      // The first samples add nothing still.
      const int32_t clear =
          kept != nullptr ? std::clamp(kept->clear[i] - first_[x], 0, count_[x]) : 0;
      batch_->add(positions_, x, count_[x], clear, room, i);
    }
  }

  float thickness(size_t x) const { return static_cast<float>(exit_[x] - entry_[x] - kSliceDoubt); }

  // The extinction that the function's table guarantees for d slices. The floor counts one slice
  // less, because one sample may be missing.
  static float byTable(float floor, float ratio, float d) {
    return floor * (d - 1) + (ratio - floor) * d;
  }

  // Rays that cross enough of the block take the extinction from its table, which may exceed that
  // of its parts.
  void noteTable(const Place& place, size_t row) {
    for (size_t x = first_x(); x < end_x(); ++x) {
      const float d = thickness(x);
      if (d >= place.least_slices && !is_known_[row + x])
        by_table_[row + x] = byTable(floor_, ratio_, d);
    }
  }

  // The forms that know the block as a whole.
  void setWhole(const Box3& cells, const Place& place, float floor, float ratio) {
    // No ray is thicker, so that a line through this opacity lies below the opacity's curve.
    most_ = std::max(place.least_slices, slicesOf(length(toDouble(cells.size()))));
    at_most_ = -std::expm1(-byTable(floor, ratio, most_));
  }
  void addWhole(const Place& place, size_t row) {
    const float pof = std::max(byTable(floor_, ratio_, place.least_slices), 0.0F);
    for (size_t x = first_x(); x < end_x(); ++x) {
      if (is_known_[row + x]) continue;
      added_[row + x] = 0;
      const float d = thickness(x);
      if (!(ratio_ > 0) || !place.has_ratio || d < place.least_slices) continue;
      added_[row + x] = pof;
      if (of_.options_.form == OpacityForm::kLinearOpof)
        added_[row + x] =
            std::max(pof, -std::log1p(-at_most_ * std::max(d - 1, 0.0F) / (most_ - 1)));
    }
  }

  const SeriesOpacity& series() const { return *of_.series_; }
  // The most slices in a length of index space.
  float slicesOf(double vox) const {
    double step = length(of_.view_.rays.step0);
    if (!of_.view_.parallel) {
      // The shortest step of any ray: the one in the picture's middle, or shorter if axes differ.
      step = std::numeric_limits<double>::infinity();
      const RayGrid& rays = of_.view_.rays;
      for (const double x : {0.0, 0.5, 1.0})
        for (const double y : {0.0, 0.5, 1.0})
          step = std::min(step, length(rays.step0 + rays.step_dx * (x * of_.view_.size.width) +
                                       rays.step_dy * (y * of_.view_.size.height)));
      step *= 0.5;
    }
    return static_cast<float>(vox / step);
  }

  const VisibilityEstimate& of_;
  UnpackedParts& unpacked_;
  const Rect tile_;
  const int width_, height_;
  TileRays rays_;
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;  // pixels of the tile that a block may cover
  TilePixels sum_{};
  std::array<bool, static_cast<size_t>(kSide)> is_open_{};  // rows with a ray that is not opaque
  // State of the block that is added.
  bool is_set_ = false, whole_ = false, has_parts_ = false;
  float floor_ = 0, ratio_ = 0;
  Vec3d lo_;
  TileRays::BoxPlanes planes_{};
  const UnpackedParts::Parts* parts_ = nullptr;
  UnpackedParts::Parts shown_parts_;  // the parts of a block that is cut
  std::array<int32_t, 3> part_count_{};
  double cube_cells_ = 1;
  float most_ = 0, at_most_ = 0;
  std::optional<SampleBatch> batch_;
  TilePixels added_{}, by_table_{};
  std::array<bool, kTilePixels> is_known_{};
  std::array<int32_t, kTilePixels> firsts_{}, counts_{}, taken_{}, clear_{};  // samples
  // State of the row.
  TileRays::Slices entry_{}, exit_{};
  TileRays::Samples first_{}, count_{};
  TileRays::Positions positions_{};
};

float VisibilityEstimate::ratioOf(const OpacityFunction& function, const Place& place) const {
  const float floor = extinction_[function.floor];
  if (function.ratios.empty() || !place.has_ratio) return floor;
  uint8_t least = 255;
  for (const int cell : place.directions)
    least = std::min(least, function.ratios[static_cast<size_t>(cell)]);
  return std::max(floor, extinction_[least]);
}

// Applies the changes to the values that a tile keeps, and drops those that may differ. The place
// of the first block from which on the tile has to be looked at; nullopt: its answer stays.
std::optional<size_t> VisibilityEstimate::firstAffected(Task& task) {
  Tile& tile = tiles_[task.tile];
  std::optional<size_t> first;
  for (const size_t place : task.changed) {
    const uint32_t block = tile.blocks[place];
    const Change& change = changes_[block];
    Added* kept = tile.added.empty() ? nullptr : tile.added[place].get();
    bool differs = false;
    for (const ChangedPart& part : change.parts) {
      const int x0 = std::max(part.pixels.x0, tile.pixels.x0) - tile.pixels.x0;
      const int x1 = std::min(part.pixels.x1, tile.pixels.x1) - tile.pixels.x0;
      const int y0 = std::max(part.pixels.y0, tile.pixels.y0) - tile.pixels.y0;
      const int y1 = std::min(part.pixels.y1, tile.pixels.y1) - tile.pixels.y0;
      if (x0 >= x1 || y0 >= y1) continue;
      differs = differs || kept == nullptr;
      if (kept == nullptr) continue;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const size_t pixel = TileRays::pixelAt(x, y);
          // Samples behind the one that made the ray opaque were not looked at.
          if (part.near > kept->end[pixel]) continue;
          kept->along[pixel] = -0.0F;
          kept->clear[pixel] = std::min(kept->clear[pixel], beforeSlice(part.near));
          differs = true;
        }
    }
    if (kept != nullptr) kept->function = functions_[block];
    if (differs && tile.reached[place]) first = std::min(place, first.value_or(place));
  }
  return first;
}

void VisibilityEstimate::estimateTile(Task& task) {
  Tile& tile = tiles_[task.tile];
  size_t first = 0;
  if (!task.changed.empty()) {
    const std::optional<size_t> affected = firstAffected(task);
    task.is_affected = affected.has_value();
    if (!affected) return;
    // Without kept sums all blocks have to be added again.
    if (!tile.added.empty()) first = *affected;
  }
  std::unique_ptr<UnpackedParts> unpacked = takeUnpacked();
  TileWork work(*this, tile, *unpacked);
  bool is_opaque = false;
  for (size_t i = 0; i < tile.blocks.size(); ++i) {
    const uint32_t block = tile.blocks[i];
    // Blocks up to the first change are reached as before. Those behind it see another buffer.
    if (i > first || first == 0) tile.reached[i] = !is_opaque && work.reaches(block);
    if (!tile.reached[i]) continue;
    const int32_t now = functions_[block];
    const OpacityFunction& function = series_->functions[static_cast<size_t>(now)];
    if (function.empty()) continue;
    Added* kept = nullptr;
    if (!tile.added.empty()) {
      if (tile.added[i] == nullptr) tile.added[i] = std::make_unique<Added>();
      kept = tile.added[i].get();
      if (kept->function != now) {
        kept->along.fill(-0.0F);
        kept->clear.fill(kNoneClear);
      }
      kept->function = now;
    }
    work.add(block, function, kept);
    is_opaque = work.isOpaque();
  }
  giveBack(std::move(unpacked));
}

}  // namespace sluice
