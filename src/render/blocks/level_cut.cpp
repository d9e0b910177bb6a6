#include "src/render/blocks/level_cut.h"

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/render/blocks/cut_rules.h"
#include "src/render/blocks/shown_levels.h"
#include "src/render/camera/pixel_sizes.h"

namespace sluice {
namespace {

// Bytes of a block, and of all that are chosen; `read`: those of `held` that are not in memory.
struct BlockBytes {
  uint64_t stored = 0, held = 0, read = 0;
  void add(const BlockBytes& more) {
    stored += more.stored;
    held += more.held;
    read += more.read;
  }
  void remove(const BlockBytes& less) {
    stored -= less.stored;
    held -= less.held;
    read -= less.read;
  }
};
// Parts that stay refined do so until their voxels are this many times the pixel error wide.
constexpr double kKeepsRefined = 0.7;

struct CutNode {
  int level = 0;
  Vec3i index;
  ObjectBlock object;
  BlockBytes bytes;
};

// Makes one cut.
class CutMaker {
 public:
  CutMaker(const BlockQuestion& question, ShownLevels& shown)
      : question_(question),
        options_(*question.cut),
        shown_(shown),
        pyramid_(shown.pyramid()),
        limit_(question.limit),
        sizes_(question.step.source->layout(), question.view),
        held_bytes_(bytesPerVoxel(question.step.ranges->map.type)),
        holds_extremes_(std::ranges::any_of(question.step.coarser, [](const CoarserStep& level) {
          return level.valuesShown() == LevelValues::kMaxima ||
                 level.valuesShown() == LevelValues::kMinima;
        })) {}

  void makeLevel(int level) {
    addAll(level, [&](Vec3i index) {
      return std::optional(shown_.objectOf(level, index, question_.step.time));
    });
    chosen_ = std::move(open_);
  }

  void make() {
    const int top = pyramid_.levels() - 1;
    addAll(top, [&](Vec3i index) { return shown_.partOf(top, index, question_.step.time); });
    for (int level = top; level > 0; --level) refine();
    chosen_.insert(chosen_.end(), std::make_move_iterator(open_.begin()),
                   std::make_move_iterator(open_.end()));
  }

  VisibleBlocks result() {
    VisibleBlocks blocks;
    blocks.white = left_out_;
    std::map<int, CutSummary::Level> levels;
    int64_t thin_blocks = 0;
    for (CutNode& node : chosen_) {
      if (node.object.cells.empty()) {
        ++blocks.white;
        continue;
      }
      ++(node.object.kind == BlockClass::kBlack ? blocks.black : blocks.grey);
      CutSummary::Level& level = levels[node.level];
      level.level = node.level;
      ++level.blocks;
      level.cells += node.object.cells.count();
      thin_blocks += isThin(node) ? 1 : 0;
      blocks.blocks.push_back(node.object);
    }
    std::ranges::sort(blocks.blocks, {}, &ObjectBlock::name);
    CutSummary summary;
    summary.has_spreads = true;
    for (const auto& [number, level] : levels) {
      summary.levels.push_back(level);
      if (number > 0 && pyramid_.level(number).numbers != 2) summary.has_spreads = false;
    }
    if (!question_.step.coarser.empty())
      summary.values = question_.step.coarser.front().valuesShown();
    const int64_t shown = levels.contains(0) ? levels[0].cells : 0;
    summary.coarse_share = shown_.coarseShare(shown);
    summary.is_final = !is_stopped_ && !awaits_data_;
    summary.will_improve = awaits_data_;
    summary.thin_blocks = thin_blocks;
    blocks.cut = std::move(summary);
    std::ranges::sort(refined_);
    blocks.refined = std::move(refined_);
    return blocks;
  }

 private:
  CutNode nodeOf(int level, Vec3i index, const ObjectBlock& object) const {
    CutNode node{level, index, object, {}};
    if (node.object.cells.empty()) return node;
    const LevelLayout& at = pyramid_.level(level);
    const auto voxels = static_cast<uint64_t>(at.blocks.storedVoxels(index).count());
    const VoxelType type = question_.step.source->layout().type;
    node.bytes = {voxels * storedBytesPerVoxel(type, at.numbers),
                  voxels * held_bytes_ * static_cast<uint64_t>(at.numbers), 0};
    return node;
  }

  // The node, with the bytes that are to be read for it.
  CutNode withReading(CutNode node) {
    if (limit_ != nullptr && !isInMemory(node)) node.bytes.read = node.bytes.held;
    return node;
  }

  // Whether the block is in memory, or all the finer blocks that the pixel error asks for there.
  bool isInMemory(const CutNode& node) {
    const auto [known, is_new] = in_memory_.try_emplace(node.object.name, false);
    if (!is_new) return known->second;
    bool is_there = node.object.cells.empty() || limit_->is_in_memory(node.object.name);
    if (!is_there && node.level > 0 && isTooCoarse(node))
      is_there = std::ranges::all_of(childrenOf(node),
                                     [this](const CutNode& child) { return isInMemory(child); });
    in_memory_[node.object.name] = is_there;
    return is_there;
  }

  bool wasRefined(const BlockName& name) const {
    return limit_ != nullptr && limit_->last != nullptr &&
           std::ranges::binary_search(limit_->last->refined, name);
  }

  // Opens the blocks of a level of which there is an object.
  void addAll(int level, const auto& object_of) {
    const BlockLayout& blocks = pyramid_.level(level).blocks;
    for (int64_t block = 0; block < blocks.blockCount(); ++block) {
      const Vec3i index = blocks.indexOf(block);
      const std::optional<ObjectBlock> object = object_of(index);
      if (!object) {
        ++left_out_;
        continue;
      }
      open_.push_back(withReading(nodeOf(level, index, *object)));
      bytes_.add(open_.back().bytes);
    }
  }

  bool fits() const {
    return bytes_.stored <= options_.most_stored_bytes && bytes_.held <= options_.most_held_bytes;
  }

  // Whether these blocks, which are chosen now, come in time.
  bool comeInTime(const std::vector<CutNode>& nodes) {
    if (limit_ == nullptr) return true;
    uint64_t read = 0;
    for (const CutNode& node : nodes) read += node.bytes.read;
    if (read == 0) return true;
    const bool reads_one = limit_->refines_some && !reads_any_;
    if (bytes_.read > limit_->most_bytes && !reads_one) return false;
    reads_any_ = true;
    return true;
  }

  std::vector<CutNode> childrenOf(const CutNode& node) {
    std::vector<CutNode> nodes;
    const Box3 children = pyramid_.childrenOf(node.level, node.index);
    for (int64_t z = children.lo.z; z < children.hi.z; ++z)
      for (int64_t y = children.lo.y; y < children.hi.y; ++y)
        for (int64_t x = children.lo.x; x < children.hi.x; ++x)
          if (const auto part = shown_.partOf(node.level - 1, {x, y, z}, question_.step.time))
            nodes.push_back(nodeOf(node.level - 1, {x, y, z}, *part));
    return nodes;
  }

  double pixelsOf(const CutNode& node) const {
    return sizes_.of(pyramid_.level(node.level), pyramid_.regionOf(node.level, node.index));
  }
  // Whether a coarse block in the picture may show next to nothing of what is there. Extremes do
  // not, as long as a ray meets them.
  bool isThin(const CutNode& node) const {
    return node.level > 0 && !holds_extremes_ && pixelsOf(node) > 0 &&
           shown_.hasThinParts(node.level, node.index);
  }
  bool isTooCoarse(const CutNode& node) const {
    const bool is_kept = limit_ != nullptr && limit_->keeps_refined && wasRefined(node.object.name);
    return pixelsOf(node) > options_.pixel_error * (is_kept ? kKeepsRefined : 1) ||
           (options_.keeps_thin && isThin(node));
  }

  // Replaces the open nodes, all of one level, by nodes of the next finer level if they are too
  // coarse.
  void refine() {
    std::vector<std::pair<double, size_t>> wide;  // depth, position in open_
    for (size_t i = 0; i < open_.size(); ++i) {
      const Box3 region = pyramid_.regionOf(open_[i].level, open_[i].index);
      if (!is_stopped_ && isTooCoarse(open_[i]))
        wide.emplace_back(sizes_.depthOf(region), i);
      else
        chosen_.push_back(open_[i]);
    }
    std::ranges::sort(wide);
    std::vector<CutNode> finer;
    for (const auto& [depth, i] : wide) {
      const CutNode& node = open_[i];
      if (!is_stopped_) {
        std::vector<CutNode> children = childrenOf(node);
        for (CutNode& child : children) child = withReading(child);
        const BlockBytes before = bytes_;
        bytes_.remove(node.bytes);
        for (const CutNode& child : children) bytes_.add(child.bytes);
        if (!fits()) {
          is_stopped_ = true;
        } else if (!comeInTime(children)) {
          awaits_data_ = true;
        } else {
          finer.insert(finer.end(), children.begin(), children.end());
          refined_.push_back(node.object.name);
          continue;
        }
        bytes_ = before;
      }
      chosen_.push_back(node);
    }
    open_ = std::move(finer);
  }

  const BlockQuestion& question_;
  const CutOptions& options_;
  ShownLevels& shown_;
  const PyramidLayout& pyramid_;
  const ReadLimit* const limit_;  // null: none
  const PixelSizes sizes_;
  const uint64_t held_bytes_;  // of a number
  const bool holds_extremes_;  // the coarser levels do
  std::vector<CutNode> open_, chosen_;
  BlockBytes bytes_;  // bytes of open_ and chosen_
  int64_t left_out_ = 0;
  std::vector<BlockName> refined_;
  std::unordered_map<BlockName, bool, BlockNameHash> in_memory_;  // see isInMemory()
  bool is_stopped_ = false;
  bool awaits_data_ = false;  // a part stays coarse for want of time
  bool reads_any_ = false;    // a part was refined by blocks that are to be read
};

bool isSame(const VisibleBlocks& a, const VisibleBlocks& b) {
  return std::ranges::equal(a.blocks, b.blocks,
                            [](const ObjectBlock& x, const ObjectBlock& y) {
                              return x.name == y.name && x.cells == y.cells;
                            }) &&
         a.cut->is_final == b.cut->is_final && a.cut->will_improve == b.cut->will_improve &&
         a.cut->thin_blocks == b.cut->thin_blocks;
}

}  // namespace

TimeStep LevelCut::listed(const TimeStep& step) {
  TimeStep with_listing = step;
  if (!step.ranges->is_listed && followsFinest(step))
    with_listing.ranges =
        listed_.of(step, [&] { return listedRanges(step.ranges, *step.source, step.time); });
  return with_listing;
}

VisibleBlocksPtr LevelCut::choose(const BlockQuestion& question) {
  SLUICE_CHECK(question.cut.has_value());
  requireLevel(*question.cut, question.step);
  const TimeStep step = listed(question.step);
  const std::shared_ptr<ShownLevels> shown = shown_.of({step, question.look, question.crop}, [&] {
    std::shared_ptr<const RangeTree> tree;
    if (step.ranges->is_listed)
      tree = tree_.of(step, [&] { return RangeTree(*step.ranges, step.layout(), pool_); });
    return std::make_shared<ShownLevels>(step, question.look, question.crop, std::move(tree),
                                         pool_);
  });
  CutMaker maker(question, *shown);
  if (question.cut->level)
    maker.makeLevel(*question.cut->level);
  else
    maker.make();
  auto made = std::make_shared<VisibleBlocks>(maker.result());
  // The same plan serves all views that make the same cut.
  if (answer_ != nullptr && of_answer_ == shown && isSame(*answer_, *made)) return answer_;
  of_answer_ = shown;
  answer_ = std::move(made);
  return answer_;
}

}  // namespace sluice
