#include "src/parallel/dealing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "src/base/error.h"
#include "src/parallel/hilbert.h"

namespace sluice {
namespace {

// Hands a rank that are aimed at before these are made larger.
constexpr int64_t kHandsARank = 256;

// 2^64 over the golden ratio: its multiples, modulo 2^64, fill every interval as evenly as can be,
// and so do the multiples of any stretch of successive numbers.
constexpr uint64_t kGolden = 0x9e3779b97f4a7c15;

}  // namespace

Dealing dealBlocks(const BlockLayout& layout, int ranks) {
  SLUICE_CHECK(ranks >= 1);
  Dealing dealing{layout.grid, ranks, 1, layout.cells(), 0};
  const auto handsOf = [&](int64_t hand) {
    return volume((layout.grid + Vec3i{hand - 1, hand - 1, hand - 1}) / hand);
  };
  while (handsOf(2 * dealing.hand) >= kHandsARank * ranks) dealing.hand *= 2;
  dealing.side_vox *= dealing.hand;
  const int64_t longest =
      (std::max({layout.grid.x, layout.grid.y, layout.grid.z}) + dealing.hand - 1) / dealing.hand;
  dealing.bits = std::bit_width(static_cast<uint64_t>(longest - 1));
  return dealing;
}

int Dealing::rankOf(Vec3i block) const {
  const uint64_t place = hilbertPosition(block / hand, bits) * kGolden;
  return static_cast<int>(((place >> 32) * static_cast<uint64_t>(ranks)) >> 32);
}

std::vector<int32_t> dealPicture(const Dealing& dealing, const BlockLayout& layout,
                                 const VisibleBlocks& visible) {
  std::vector<std::pair<uint64_t, size_t>>
      order;  // position of its hand along the curve, index of a block
  order.reserve(visible.blocks.size());
  for (size_t i = 0; i < visible.blocks.size(); ++i)
    order.emplace_back(
        hilbertPosition(layout.indexOf(visible.blocks[i].name.block) / dealing.hand, dealing.bits),
        i);
  std::sort(order.begin(), order.end());
  using Seat = std::pair<int64_t, int32_t>;  // blocks so far, rank
  std::priority_queue<Seat, std::vector<Seat>, std::greater<>> seats;
  for (int32_t rank = 0; rank < dealing.ranks; ++rank) seats.emplace(0, rank);
  std::vector<int32_t> ranks(order.size());
  for (size_t from = 0; from < order.size();) {
    Seat seat = seats.top();
    seats.pop();
    const uint64_t hand = order[from].first;
    for (; from < order.size() && order[from].first == hand; ++from, ++seat.first)
      ranks[order[from].second] = seat.second;
    seats.push(seat);
  }
  return ranks;
}

DealingLayers::DealingLayers(const Dealing& dealing, const FrameSetup& setup)
    : hands_((dealing.grid + Vec3i{dealing.hand - 1, dealing.hand - 1, dealing.hand - 1}) /
             dealing.hand),
      side_vox_(dealing.side_vox),
      parallel_(setup.projection == Projection::kOrtho) {
  const RayGrid& rays = setup.rays;
  for (int a = 0; a < 3; ++a) {
    if (parallel_) {
      down_[static_cast<size_t>(a)] = rays.step0[a] < 0;
      continue;
    }
    const double eye = rays.origin0[a] - rays.step0[a] * (setup.first_depth / setup.depth_step);
    const double hand = std::floor(eye / static_cast<double>(side_vox_));
    eye_[a] = static_cast<int64_t>(std::clamp(hand, 0.0, static_cast<double>(hands_[a] - 1)));
  }
}

uint32_t DealingLayers::layerOf(const Box3& cells) const {
  int64_t layer = 0;
  for (int a = 0; a < 3; ++a) {
    const int64_t at = cells.lo[a] / side_vox_;
    if (!parallel_)
      layer += std::abs(at - eye_[a]);
    else
      layer += down_[static_cast<size_t>(a)] ? hands_[a] - 1 - at : at;
  }
  return static_cast<uint32_t>(layer);
}

}  // namespace sluice
