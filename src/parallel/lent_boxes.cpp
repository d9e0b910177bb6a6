#include "src/parallel/lent_boxes.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

std::string printBox(const Box3& box) {
  return fmt::format("({}, {}, {}) to ({}, {}, {})", box.lo.x, box.lo.y, box.lo.z, box.hi.x,
                     box.hi.y, box.hi.z);
}

// A plane along an axis that no box crosses, with boxes on either side, near the middle of them.
std::optional<int64_t> planeAlong(int axis, const std::vector<Box3>& boxes,
                                  const std::vector<int>& ranks) {
  std::vector<std::pair<int64_t, int64_t>> spans;
  for (const int rank : ranks) {
    const Box3& box = boxes[static_cast<size_t>(rank)];
    spans.emplace_back(box.lo[axis], box.hi[axis]);
  }
  std::sort(spans.begin(), spans.end());
  std::optional<int64_t> best;
  const auto middle = static_cast<int64_t>(spans.size() / 2);
  int64_t best_distance = 0, reach = spans.front().second;
  for (size_t i = 1; i < spans.size(); ++i) {
    const int64_t distance = std::abs(static_cast<int64_t>(i) - middle);
    // A plane parts the boxes where each one that begins before it has ended. The one nearest to
    // the middle keeps the tree flat.
    if (spans[i].first >= reach && (!best || distance < best_distance)) {
      best = spans[i].first;
      best_distance = distance;
    }
    reach = std::max(reach, spans[i].second);
  }
  return best;
}

}  // namespace

LentBoxes::LentBoxes(std::vector<Box3> boxes, Vec3i dims, const std::string& name)
    : dims_(dims), boxes_(std::move(boxes)) {
  SLUICE_CHECK(!boxes_.empty());
  int64_t voxels = 0;
  for (size_t rank = 0; rank < boxes_.size(); ++rank) {
    const Box3& box = boxes_[rank];
    if (box.empty() || !boxOf(dims).contains(box))
      failRequest(
          "{}: rank {} lends the box from {}, expected one with voxels, within {} x {} x {}", name,
          rank, printBox(box), dims.x, dims.y, dims.z);
    voxels += box.count();
  }
  // Boxes that planes part do not overlap. If they have as many voxels as the volume, they leave no
  // gap.
  if (voxels < volume(dims))
    failRequest("{}: the ranks lend {} of {} voxels; each voxel must be in the box of one rank",
                name, voxels, volume(dims));
  std::vector<int> ranks(boxes_.size());
  std::iota(ranks.begin(), ranks.end(), 0);
  root_ = part(std::move(ranks), name);
}

int LentBoxes::part(std::vector<int> ranks, const std::string& name) {
  if (ranks.size() == 1) {
    nodes_.push_back({.rank = ranks.front()});
    return static_cast<int>(nodes_.size()) - 1;
  }
  for (int axis = 2; axis >= 0; --axis) {
    const std::optional<int64_t> plane = planeAlong(axis, boxes_, ranks);
    if (!plane) continue;
    const auto middle = std::stable_partition(ranks.begin(), ranks.end(), [&](int rank) {
      return boxes_[static_cast<size_t>(rank)].lo[axis] < *plane;
    });
    const std::vector<int> above(middle, ranks.end());
    ranks.erase(middle, ranks.end());
    Node node{.axis = axis, .plane = *plane};
    node.below = part(std::move(ranks), name);
    node.above = part(above, name);
    nodes_.push_back(node);
    return static_cast<int>(nodes_.size()) - 1;
  }
  const auto boxOfRank = [&](size_t i) { return printBox(boxes_[static_cast<size_t>(ranks[i])]); };
  failRequest(
      "{}: the boxes of the ranks cannot be put in order: no plane along an axis parts {} of them, "
      "such as those of ranks {} ({}) and {} ({}); divide the volume by planes, as a grid of boxes "
      "or a k-d tree does",
      name, ranks.size(), ranks[0], boxOfRank(0), ranks[1], boxOfRank(1));
}

Box3 LentBoxes::cellsOf(int rank) const {
  // The last voxels along an axis begin no cell.
  return intersect(boxes_[static_cast<size_t>(rank)], boxOf(dims_ - Vec3i{1, 1, 1}));
}

Box3 LentBoxes::voxelsFor(int rank, bool around) const {
  const Box3 cells = cellsOf(rank);
  if (cells.empty()) return {};
  const int64_t more = around ? 1 : 0;
  const Vec3i below{more, more, more}, above{1 + more, 1 + more, 1 + more};
  return intersect({cells.lo - below, cells.hi + above}, boxOf(dims_));
}

int LentBoxes::rankAt(Vec3i cell) const {
  int at = root_;
  while (nodes_[static_cast<size_t>(at)].below >= 0) {
    const Node& node = nodes_[static_cast<size_t>(at)];
    at = cell[node.axis] < node.plane ? node.below : node.above;
  }
  return nodes_[static_cast<size_t>(at)].rank;
}

std::vector<uint32_t> LentBoxes::layersFor(const FrameSetup& setup) const {
  const RayGrid& rays = setup.rays;
  const bool is_parallel = setup.projection == Projection::kOrtho;
  Vec3d eye;
  for (int a = 0; a < 3; ++a)
    eye[a] = rays.origin0[a] - rays.step0[a] * (setup.first_depth / setup.depth_step);
  std::vector<uint32_t> layers(boxes_.size());
  uint32_t next = 0;
  std::vector<int> waiting{root_};
  while (!waiting.empty()) {
    const Node& node = nodes_[static_cast<size_t>(waiting.back())];
    waiting.pop_back();
    if (node.below < 0) {
      layers[static_cast<size_t>(node.rank)] = next++;
      continue;
    }
    // A ray that crosses the plane goes away from the eye's side of it.
    const bool is_above_first =
        is_parallel ? rays.step0[node.axis] < 0 : eye[node.axis] > static_cast<double>(node.plane);
    // The side that is pushed last is walked first.
    waiting.push_back(is_above_first ? node.below : node.above);
    waiting.push_back(is_above_first ? node.above : node.below);
  }
  return layers;
}

}  // namespace sluice
