// One tile of the visibility estimate: blocks front to back against its opacity buffer.
#include <algorithm>
#include <cmath>
#include <limits>

#include "src/visibility/ray_rows.h"
#include "src/visibility/visibility_estimate.h"

namespace sluice {
namespace {

constexpr int kSide = VisibilityEstimate::kTileSide;
constexpr size_t kTilePixels = static_cast<size_t>(kSide) * kSide;
static_assert(kSide == TileRays::kSide);

}  // namespace

// What a thread works in.
class VisibilityEstimate::TileWork {
 public:
  TileWork(const VisibilityEstimate& of, const Tile& tile)
      : of_(of), tile_(tile.pixels), width_(tile_.x1 - tile_.x0), height_(tile_.y1 - tile_.y0) {
    rays_.set(of.view_.rays, of.view_.parallel, of.view_.first_slice, tile_.x0, tile_.y0);
  }

  // Whether a ray that is not opaque meets the block.
  bool reaches(uint32_t block) {
    const Box3 cells = of_.series_->cellsOf(block);
    setBox(cells, of_.places_[block].footprint);
    for (int y = y0_; y < y1_; ++y) {
      rays_.thickness(planes_, y, x0_, x1_, thickness_.data());
      const float* sum = sum_.data() + y * kSide + x0_;
      for (int x = 0; x < x1_ - x0_; ++x)
        if (thickness_[static_cast<size_t>(x)] > -kThicknessDoubt && sum[x] < of_.limit_)
          return true;
    }
    return false;
  }

  // What the block adds along each ray.
  void add(uint32_t block, const OpacityFunction& function) {
    const Place& place = of_.places_[block];
    const bool whole = of_.options_.form != OpacityForm::kOpof;
    if (function.empty() || (whole && !place.whole)) {
      if (!whole && rises_) addBox(of_.series_->cellsOf(block), place.footprint, 0);
      return;
    }
    const float ratio = place.whole ? of_.ratioOf(function, place) : 0;
    if (whole) {
      addWhole(block, function, ratio);
      return;
    }
    const float floor = of_.extinction_[function.floor];
    const bool has_table = ratio > floor;
    if (has_table) before_ = sum_;
    addParts(block, function);
    if (has_table) takeGreater(block, floor, ratio);
  }

  bool isOpaque() const {
    for (int y = 0; y < height_; ++y) {
      const float* sum = sum_.data() + y * kSide;
      float least = sum[0];
      for (int x = 0; x < width_; ++x) least = std::min(least, sum[x]);
      if (least < of_.limit_) return false;
    }
    return true;
  }

 private:
  void setBox(const Box3& cells, const Rect& footprint) {
    planes_ = rays_.planesOf(toDouble(cells.lo), toDouble(cells.hi));
    x0_ = std::max(footprint.x0, tile_.x0) - tile_.x0;
    x1_ = std::min(footprint.x1, tile_.x1) - tile_.x0;
    y0_ = std::max(footprint.y0, tile_.y0) - tile_.y0;
    y1_ = std::min(footprint.y1, tile_.y1) - tile_.y0;
  }

  void addBox(const Box3& cells, const Rect& footprint, float extinction) {
    setBox(cells, footprint);
    for (int y = y0_; y < y1_; ++y) {
      rays_.thickness(planes_, y, x0_, x1_, thickness_.data());
      const int at = y * kSide + x0_;
      addStretch(thickness_.data(), x1_ - x0_, extinction,
                 {sum_.data() + at, level_.data() + at, rising_.data() + at, since_.data() + at});
    }
    rises_ = rises_ || extinction > 0;
  }

  // Part by part, front to back; those of nothing end what is in front of them.
  void addParts(uint32_t block, const OpacityFunction& function) {
    const Place& place = of_.places_[block];
    const Box3 cells = of_.series_->cellsOf(block);
    if (function.parts.empty() && place.whole) {
      addBox(cells, place.footprint, of_.extinction_[function.floor]);
      return;
    }
    const PartGrid grid = of_.series_->partsOf(block);
    const Vec3i count = grid.count();
    for (int a = 0; a < 3; ++a) setOrder(a, count[a], grid.side, cells.lo[a]);
    // Layers and rows of parts first: most have nothing in a tile.
    for (const int64_t z : order_[2]) {
      const Box3 layer{grid.cellsOf({0, 0, z}).lo + cells.lo,
                       grid.cellsOf({count.x - 1, count.y - 1, z}).hi + cells.lo};
      if (!meets(of_.footprintOf(layer))) continue;
      for (const int64_t y : order_[1]) {
        const Box3 row{grid.cellsOf({0, y, z}).lo + cells.lo,
                       grid.cellsOf({count.x - 1, y, z}).hi + cells.lo};
        if (!meets(of_.footprintOf(row))) continue;
        for (const int64_t x : order_[0])
          addPart(translate(grid.cellsOf({x, y, z}), cells.lo), place.whole,
                  function.parts.empty()
                      ? function.floor
                      : function.parts[static_cast<size_t>((z * count.y + y) * count.x + x)]);
      }
    }
  }

  // That of a parallel view is that of the last block, if it has as many parts.
  void setOrder(int axis, int64_t count, int64_t side, int64_t first) {
    std::vector<int64_t>& order = order_[static_cast<size_t>(axis)];
    if (of_.view_.parallel && static_cast<int64_t>(order.size()) == count) return;
    order = of_.axisOrder(axis, 0, count, side, first);
  }

  void addPart(const Box3& part, bool block_is_whole, uint8_t packed) {
    if (packed > 0 && !block_is_whole && !of_.isShown(part)) packed = 0;
    if (packed == 0 && !rises_) return;
    const Rect footprint = of_.footprintOf(part);
    if (meets(footprint)) addBox(part, footprint, of_.extinction_[packed]);
  }

  bool meets(const Rect& footprint) const {
    return footprint.x0 < tile_.x1 && footprint.x1 > tile_.x0 && footprint.y0 < tile_.y1 &&
           footprint.y1 > tile_.y0;
  }

  // For rays that cross enough of the block, what its table says where that is more than what its
  // parts do.
  void takeGreater(uint32_t block, float floor, float ratio) {
    const Place& place = of_.places_[block];
    setBox(of_.series_->cellsOf(block), place.footprint);
    for (int y = y0_; y < y1_; ++y) {
      rays_.thickness(planes_, y, x0_, x1_, thickness_.data());
      const size_t row = static_cast<size_t>(y * kSide + x0_);
      for (size_t x = 0; x < static_cast<size_t>(x1_ - x0_); ++x) {
        const float d = thickness_[x] - kThicknessDoubt;
        if (d < place.least_slices) continue;
        const float by_table = before_[row + x] + floor * (d - 1) + (ratio - floor) * d;
        if (by_table <= sum_[row + x]) continue;
        sum_[row + x] = by_table;
        level_[row + x] = rising_[row + x] = since_[row + x] = 0;
      }
    }
  }

  // The forms that know the block as a whole.
  void addWhole(uint32_t block, const OpacityFunction& function, float ratio) {
    const Place& place = of_.places_[block];
    const float floor = of_.extinction_[function.floor];
    const float least = place.least_slices;
    if (!(ratio > 0) || !place.has_ratio) return;
    // A slice may be missing of what the floor says: see addStretch().
    const auto sumOf = [&](float d) { return floor * (d - 1) + (ratio - floor) * d; };
    const float pof = std::max(sumOf(least), 0.0F);
    // No ray is thicker, so that a line through this opacity lies below the opacity's curve.
    const Vec3d size = toDouble(series().cellsOf(block).size());
    const float most = std::max(least, slicesOf(length(size)));
    const float at_most = -std::expm1(-sumOf(most));
    setBox(series().cellsOf(block), place.footprint);
    for (int y = y0_; y < y1_; ++y) {
      rays_.thickness(planes_, y, x0_, x1_, thickness_.data());
      float* sum = sum_.data() + y * kSide + x0_;
      for (int x = 0; x < x1_ - x0_; ++x) {
        const float d = thickness_[static_cast<size_t>(x)] - kThicknessDoubt;
        if (d < least) continue;
        if (of_.options_.form == OpacityForm::kPof)
          sum[x] += pof;
        else
          sum[x] += std::max(pof, -std::log1p(-at_most * std::max(d - 1, 0.0F) / (most - 1)));
      }
    }
  }
  const SeriesOpacity& series() const { return *of_.series_; }
  // At most so many slices in a length of index space.
  float slicesOf(double vox) const {
    double step = length(of_.view_.rays.step0);
    if (!of_.view_.parallel) {
      // The shortest step of any ray: of the picture's middle, or shorter where axes differ.
      step = std::numeric_limits<double>::infinity();
      const RayGrid& rays = of_.view_.rays;
      for (int i = 0; i < 9; ++i)
        step = std::min(step,
                        length(rays.step0 + rays.step_dx * (0.5 * (i % 3) * of_.view_.size.width) +
                               rays.step_dy * (0.5 * (i / 3) * of_.view_.size.height)));
      step *= 0.5;
    }
    return static_cast<float>(vox / step);
  }

  const VisibilityEstimate& of_;
  const Rect tile_;
  const int width_, height_;
  TileRays rays_;
  TileRays::BoxPlanes planes_{};
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
  bool rises_ = false;                         // something was added
  std::array<std::vector<int64_t>, 3> order_;  // of parts
  std::array<float, kTilePixels> sum_{}, before_{}, level_{}, rising_{}, since_{};
  std::array<float, static_cast<size_t>(kSide)> thickness_{};
};

float VisibilityEstimate::ratioOf(const OpacityFunction& function, const Place& place) const {
  const float floor = extinction_[function.floor];
  if (function.ratios.empty() || !place.has_ratio) return floor;
  uint8_t least = 255;
  for (const int cell : place.directions)
    least = std::min(least, function.ratios[static_cast<size_t>(cell)]);
  return std::max(floor, extinction_[least]);
}

void VisibilityEstimate::estimateTile(Tile& tile) const {
  TileWork work(*this, tile);
  tile.reached.assign(tile.blocks.size(), false);
  for (size_t i = 0; i < tile.blocks.size(); ++i) {
    const uint32_t block = tile.blocks[i];
    if (!work.reaches(block)) continue;
    tile.reached[i] = true;
    const OpacityFunction& function = series_->functions[static_cast<size_t>(functions_[block])];
    work.add(block, function);
    if (!function.empty() && work.isOpaque()) break;
  }
}

}  // namespace sluice
