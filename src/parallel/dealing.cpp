#include "src/parallel/dealing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "src/base/error.h"
#include "src/parallel/hilbert.h"

namespace sluice {
namespace {

// Hands a rank that are aimed at before these are made larger.
constexpr int64_t kHandsARank = 256;
// Fewer would leave some ranks without work.
constexpr int kLeastHandsARank = 8;

// 2^64 over the golden ratio: its multiples, modulo 2^64, fill every interval as evenly as can be,
// and so do the multiples of any stretch of successive numbers.
constexpr uint64_t kGolden = 0x9e3779b97f4a7c15;

}  // namespace

Dealing dealBlocks(const PyramidLayout& pyramid, int ranks, int level) {
  SLUICE_CHECK(ranks >= 1);
  const int64_t cells = pyramid.finest().cells();
  // The finest blocks a side of a hand that hold whole blocks of a level, and how many hands there
  // are then: where a level's grid ends sooner, its last blocks have the rest.
  const auto sideFor = [&](int64_t hand, int of) {
    for (int a = 0; a < 3; ++a) hand = std::lcm(hand, pyramid.level(of).width[a] / cells);
    return hand;
  };
  const auto gridOf = [&](int64_t hand, int of) {
    Vec3i grid = pyramid.finest().grid;
    for (int i = 0; i <= of; ++i) {
      const Vec3i width = pyramid.level(i).width / cells, side = Vec3i{hand, hand, hand} / width;
      grid = min(grid, (pyramid.level(i).blocks.grid + side - Vec3i{1, 1, 1}) / side);
    }
    return grid;
  };
  Dealing dealing;
  dealing.ranks = ranks;
  // Smaller hands balance better, and each crossing between hands costs a layer: this is between
  // the two.
  while (volume(gridOf(2 * dealing.hand, 0)) >= kHandsARank * ranks) dealing.hand *= 2;
  for (int of = 1; of < pyramid.levels(); ++of) {
    const int64_t hand = sideFor(dealing.hand, of);
    const bool is_enough = volume(gridOf(hand, of)) >= int64_t{kLeastHandsARank} * ranks;
    // The levels up to the one that is asked for are taken even if few hands are left. Coarser ones
    // are added as long as the hands stay as they are, or enough of them are left.
    if (of > level && hand != dealing.hand && !is_enough) break;
    dealing.hand = hand;
    dealing.coarsest_level = of;
  }
  dealing.hands = gridOf(dealing.hand, dealing.coarsest_level);
  dealing.side_vox = cells * dealing.hand;
  const int64_t longest = std::max({dealing.hands.x, dealing.hands.y, dealing.hands.z});
  dealing.bits = std::bit_width(static_cast<uint64_t>(longest - 1));
  return dealing;
}

Dealing dealLent(std::shared_ptr<const LentBoxes> boxes) {
  Dealing dealing;
  dealing.ranks = boxes->count();
  dealing.hands = {dealing.ranks, 1, 1};  // as many layers as ranks
  dealing.lent = std::move(boxes);
  return dealing;
}

int Dealing::rankOf(Vec3i block) const {
  const Vec3i at = min(block / hand, hands - Vec3i{1, 1, 1});
  // The upper bits are what the multiples fill evenly. They are scaled to the ranks without a
  // division.
  const uint64_t place = hilbertPosition(at, bits) * kGolden;
  return static_cast<int>(((place >> 32) * static_cast<uint64_t>(ranks)) >> 32);
}

std::vector<int32_t> dealPicture(const Dealing& dealing, const PyramidLayout& pyramid,
                                 const VisibleBlocks& visible) {
  std::vector<std::pair<uint64_t, size_t>>
      order;  // position of its hand along the curve, index of a block
  order.reserve(visible.blocks.size());
  for (size_t i = 0; i < visible.blocks.size(); ++i)
    order.emplace_back(
        hilbertPosition(dealing.handOf(pyramid.regionOf(visible.blocks[i].name).lo), dealing.bits),
        i);
  // Every rank makes the same list in the same order and deals for all, so that no rank needs to
  // tell another.
  std::sort(order.begin(), order.end());
  using Seat = std::pair<int64_t, int32_t>;  // blocks so far, rank
  std::priority_queue<Seat, std::vector<Seat>, std::greater<>> seats;
  for (int32_t rank = 0; rank < dealing.ranks; ++rank) seats.emplace(0, rank);
  std::vector<int32_t> ranks(order.size());
  for (size_t from = 0; from < order.size();) {
    Seat seat = seats.top();
    seats.pop();
    // Blocks of a hand stay on one rank: they are in one layer, and may hide each other.
    const uint64_t hand = order[from].first;
    for (; from < order.size() && order[from].first == hand; ++from, ++seat.first)
      ranks[order[from].second] = seat.second;
    seats.push(seat);
  }
  return ranks;
}

DealingLayers::DealingLayers(const Dealing& dealing, const FrameSetup& setup)
    : dealing_(dealing), parallel_(setup.projection == Projection::kOrtho) {
  if (dealing_.lent) {
    of_ranks_ = dealing_.lent->layersFor(setup);
    return;
  }
  const RayGrid& rays = setup.rays;
  for (int a = 0; a < 3; ++a) {
    if (parallel_) {
      down_[static_cast<size_t>(a)] = rays.step0[a] < 0;
      continue;
    }
    // The eye lies where the depth along a ray would be 0.
    const double eye = rays.origin0[a] - rays.step0[a] * (setup.first_depth / setup.depth_step);
    const double hand = std::floor(eye / static_cast<double>(dealing_.side_vox));
    eye_[a] =
        static_cast<int64_t>(std::clamp(hand, 0.0, static_cast<double>(dealing_.hands[a] - 1)));
  }
}

uint32_t DealingLayers::layerOf(const Box3& cells) const {
  if (dealing_.lent) return of_ranks_[static_cast<size_t>(dealing_.lent->rankAt(cells.lo))];
  int64_t layer = 0;
  const Vec3i hand = dealing_.handOf(cells.lo);
  for (int a = 0; a < 3; ++a) {
    const int64_t at = hand[a];
    if (!parallel_)
      layer += std::abs(at - eye_[a]);
    else
      layer += down_[static_cast<size_t>(a)] ? dealing_.hands[a] - 1 - at : at;
  }
  return static_cast<uint32_t>(layer);
}

}  // namespace sluice
