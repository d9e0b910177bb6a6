#include "src/render/blocks/cut/cut_maker.h"

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/render/blocks/cut/level_faces.h"
#include "src/render/camera/pixel_sizes.h"

namespace sluice {
namespace {

// Bytes of blocks; `read`: those of `held` that are not in memory.
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

// A volume's part in a block's region.
struct CutPart {
  std::optional<ObjectBlock> object;  // nullopt: nothing
  BlockBytes bytes;

  bool isEmpty() const { return !object || object->cells.empty(); }
};
struct CutNode {
  int level = 0;
  Vec3i index;
  size_t first_part = 0;  // of the volumes' parts, see CutMaker::partsOf()
};

// Makes one cut of all volumes: a block is in it with the parts of all that have one there.
class CutMaker {
 public:
  CutMaker(std::span<const BlockQuestion> questions,
           const std::vector<std::shared_ptr<ShownLevels>>& shown)
      : options_(*questions.front().cut),
        pyramid_(shown.front()->pyramid()),
        sizes_(questions.front().step.source->layout(), questions.front().view) {
    for (size_t i = 0; i < questions.size(); ++i) {
      volumes_.push_back({questions[i], *shown[i], *questions[i].cut});
      levels_ = std::min(levels_, levelsInCommon(pyramid_, shown[i]->pyramid()));
    }
    for (const CoarserStep& level : questions.front().step.coarser)
      holds_extremes_ = holds_extremes_ || level.valuesShown() == LevelValues::kMaxima ||
                        level.valuesShown() == LevelValues::kMinima;
  }

  void makeLevel(int level) {
    SLUICE_CHECK(level < levels_);
    addAll(level, [&](Volume& of, Vec3i index) {
      return std::optional(of.shown.objectOf(level, index, of.question.step.time));
    });
    chosen_ = std::move(open_);
  }

  void make() {
    const int top = levels_ - 1;
    addAll(top, [&](Volume& of, Vec3i index) {
      return of.shown.partOf(top, index, of.question.step.time);
    });
    for (int level = top; level > 0; --level) refine();
    chosen_.insert(chosen_.end(), open_.begin(), open_.end());
  }

  // The blocks of a volume.
  VisibleBlocks result(size_t number) {
    Volume& of = volumes_[number];
    VisibleBlocks blocks;
    blocks.white = of.left_out;
    std::map<int, CutSummary::Level> levels;
    int64_t finest_cells = 0;
    for (const CutNode& node : chosen_) {
      const CutPart& part = partsOf(node)[number];
      if (!part.object) continue;
      // The region shows nothing of this volume at this level, although another volume or level has
      // something.
      if (part.isEmpty()) {
        ++blocks.white;
        continue;
      }
      ++(part.object->kind == BlockClass::kBlack ? blocks.black : blocks.grey);
      CutSummary::Level& level = levels[node.level];
      level.level = node.level;
      ++level.blocks;
      if (node.level == 0) finest_cells += of.shown.finestCells(node.index);
      if (isThin(of, node)) blocks.thin.push_back(part.object->name);
      blocks.blocks.push_back(*part.object);
    }
    std::ranges::sort(blocks.blocks, {}, &ObjectBlock::name);
    // Only surfaces leave cracks between levels, see level_borders.h.
    if (levels.size() > 1 && !of.question.look->table.surfaces().empty()) {
      setLevelFaces(pyramid_, blocks.blocks);
      const auto isOpaque = [](const auto& surface) { return surface.opacity >= 1; };
      const auto isInPicture = [&](const BlockName& name) {
        return sizes_.of(pyramid_.of(name), pyramid_.regionOf(name)) > 0;
      };
      blocks.seams = takeLevelSeams(
          pyramid_,
          {.crop = of.question.crop,
           .with_edges = std::ranges::any_of(of.question.look->transfer.surfaces, isOpaque),
           .is_in_picture = isInPicture},
          blocks.blocks);
    }
    for (const ObjectBlock& block : blocks.blocks)
      levels[block.name.level].cells += block.cells.count();
    CutSummary summary;
    summary.has_spreads = true;
    for (const auto& [level_number, level] : levels) {
      summary.levels.push_back(level);
      // Without spreads, a coarse block shows the look of its means, not the mean of looks.
      if (level_number > 0 && of.shown.pyramid().level(level_number).numbers != 2)
        summary.has_spreads = false;
    }
    const std::vector<CoarserStep>& coarser = of.question.step.coarser;
    if (!coarser.empty()) summary.values = coarser.front().valuesShown();
    summary.coarse_share = of.shown.coarseShare(finest_cells);
    summary.is_final = !is_stopped_ && !awaits_data_;
    summary.will_improve = awaits_data_;
    summary.thin_blocks = static_cast<int64_t>(blocks.thin.size());
    blocks.cut = std::move(summary);
    for (const CutNode& node : refined_)
      if (const CutPart& part = partsOf(node)[number]; part.object)
        blocks.refined.push_back(part.object->name);
    std::ranges::sort(blocks.refined);
    std::ranges::sort(blocks.thin);
    return blocks;
  }

 private:
  struct Volume {
    const BlockQuestion& question;
    ShownLevels& shown;
    const CutOptions& options;
    BlockBytes bytes = {};  // of open_ and chosen_
    int64_t left_out = 0;
    std::unordered_map<BlockName, bool, BlockNameHash> in_memory = {};  // see isInMemory()
  };

  std::span<CutPart> partsOf(const CutNode& node) {
    return std::span(parts_).subspan(node.first_part, volumes_.size());
  }

  // The node, if a volume has a part of it.
  std::optional<CutNode> nodeOf(int level, Vec3i index, const auto& object_of) {
    const CutNode node{level, index, parts_.size()};
    for (Volume& of : volumes_) parts_.push_back({object_of(of, index), {}});
    const std::span<CutPart> parts = partsOf(node);
    if (std::ranges::none_of(parts, [](const CutPart& part) { return part.object.has_value(); })) {
      // No volume shows anything: the parts are taken back.
      parts_.resize(node.first_part);
      return std::nullopt;
    }
    for (size_t i = 0; i < parts.size(); ++i)
      if (!parts[i].isEmpty()) parts[i].bytes = bytesOf(volumes_[i], level, index);
    return node;
  }

  static BlockBytes bytesOf(const Volume& of, int level, Vec3i index) {
    const TimeStep& step = of.question.step;
    const LevelLayout& at = of.shown.pyramid().level(level);
    const auto voxels = static_cast<uint64_t>(at.blocks.storedVoxels(index).count());
    return {voxels * storedBytesPerVoxel(step.source->layout().type, at.numbers),
            voxels * bytesPerVoxel(step.ranges->map.type) * static_cast<uint64_t>(at.numbers), 0};
  }

  // Sets the bytes that are to be read for the node.
  void countReading(const CutNode& node) {
    // Without a limit nobody asks what is to be read.
    for (size_t i = 0; i < volumes_.size(); ++i)
      if (volumes_[i].question.limit != nullptr && !isInMemory(i, node)) {
        CutPart& part = partsOf(node)[i];  // isInMemory() may have moved the parts
        part.bytes.read = part.bytes.held;
      }
  }

  // Whether a volume's part is in memory, or those of all the finer blocks that the pixel error
  // asks for there.
  bool isInMemory(size_t number, const CutNode& node) {
    const CutPart part = partsOf(node)[number];
    if (part.isEmpty()) return true;
    const BlockName& name = part.object->name;
    // Entered as false first, and set at the end: this call may ask for the blocks below.
    const auto [known, is_new] = volumes_[number].in_memory.try_emplace(name, false);
    if (!is_new) return known->second;
    bool is_there = volumes_[number].question.limit->is_in_memory(name);
    // A part whose finer blocks are all there costs nothing to read either, since they are drawn in
    // its place.
    if (!is_there && node.level > 0 && isTooCoarse(node))
      is_there = std::ranges::all_of(
          childrenOf(node), [&](const CutNode& child) { return isInMemory(number, child); });
    volumes_[number].in_memory[name] = is_there;
    return is_there;
  }

  bool wasRefined(const CutNode& node) {
    for (size_t i = 0; i < volumes_.size(); ++i) {
      const ReadLimit* limit = volumes_[i].question.limit;
      const CutPart& part = partsOf(node)[i];
      // While a view moves, parts stay refined a little longer, so that nothing flickers.
      if (limit != nullptr && limit->keeps_refined && limit->last != nullptr && part.object &&
          std::ranges::binary_search(limit->last->refined, part.object->name))
        return true;
    }
    return false;
  }

  // Opens the blocks of a level of which there is an object.
  void addAll(int level, const auto& object_of) {
    const BlockLayout& blocks = pyramid_.level(level).blocks;
    for (int64_t block = 0; block < blocks.blockCount(); ++block) {
      const auto counted = [&](Volume& of, Vec3i index) {
        std::optional<ObjectBlock> object = object_of(of, index);
        if (!object) ++of.left_out;
        return object;
      };
      if (const auto node = nodeOf(level, blocks.indexOf(block), counted)) {
        countReading(*node);
        open_.push_back(*node);
        add(*node);
      }
    }
  }

  void add(const CutNode& node) {
    for (size_t i = 0; i < volumes_.size(); ++i) volumes_[i].bytes.add(partsOf(node)[i].bytes);
  }
  void remove(const CutNode& node) {
    for (size_t i = 0; i < volumes_.size(); ++i) volumes_[i].bytes.remove(partsOf(node)[i].bytes);
  }

  // Each volume has limits of its own.
  bool fits() const {
    return std::ranges::all_of(volumes_, [](const Volume& of) {
      return of.bytes.stored <= of.options.most_stored_bytes &&
             of.bytes.held <= of.options.most_held_bytes;
    });
  }

  // Whether these blocks, which are chosen now, come in time. The volumes share it.
  bool comeInTime(const std::vector<CutNode>& nodes) {
    uint64_t read = 0;
    for (const CutNode& node : nodes)
      for (const CutPart& part : partsOf(node)) read += part.bytes.read;
    // Blocks that are all in memory are always in time.
    if (read == 0) return true;
    double of_limit = 0;
    bool refines_some = false;
    // The volumes share the time: each takes a share of its own limit.
    for (const Volume& of : volumes_) {
      const ReadLimit* limit = of.question.limit;
      if (limit == nullptr || of.bytes.read == 0) continue;
      of_limit += static_cast<double>(of.bytes.read) / static_cast<double>(limit->most_bytes);
      refines_some = refines_some || limit->refines_some;
    }
    // One part is refined even if it takes longer, so that each picture of a row is better than the
    // last.
    if (of_limit > 1 && !(refines_some && !reads_any_)) return false;
    reads_any_ = true;
    return true;
  }

  std::vector<CutNode> childrenOf(const CutNode& node) {
    std::vector<CutNode> nodes;
    const int level = node.level - 1;
    const auto part = [level](Volume& of, Vec3i index) {
      return of.shown.partOf(level, index, of.question.step.time);
    };
    const Box3 children = pyramid_.childrenOf(node.level, node.index);
    for (int64_t z = children.lo.z; z < children.hi.z; ++z)
      for (int64_t y = children.lo.y; y < children.hi.y; ++y)
        for (int64_t x = children.lo.x; x < children.hi.x; ++x)
          if (const auto child = nodeOf(level, {x, y, z}, part)) nodes.push_back(*child);
    return nodes;
  }

  double pixelsOf(const CutNode& node) const {
    return sizes_.of(pyramid_.level(node.level), pyramid_.regionOf(node.level, node.index));
  }
  // Whether a coarse block in the picture may show next to nothing of what a volume has there.
  // Extremes do not, as long as a ray meets them.
  bool isThin(Volume& of, const CutNode& node) const {
    return node.level > 0 && !holds_extremes_ && pixelsOf(node) > 0 &&
           of.shown.hasThinParts(node.level, node.index);
  }
  bool losesSurface(const Volume& of, const CutNode& node, const CutPart& part) const {
    return of.question.loses_surface && node.level > 0 && !part.isEmpty() && pixelsOf(node) > 0 &&
           of.question.loses_surface(*part.object);
  }
  bool hasThin(const CutNode& node) {
    for (size_t i = 0; i < volumes_.size(); ++i)
      if (partsOf(node)[i].object &&
          (isThin(volumes_[i], node) || losesSurface(volumes_[i], node, partsOf(node)[i])))
        return true;
    return false;
  }
  bool isTooCoarse(const CutNode& node) {
    return pixelsOf(node) > widestVoxel(options_) * (wasRefined(node) ? kKeepsRefined : 1) ||
           (options_.keeps_thin && hasThin(node));
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
    // Front to back, so that the parts in front are refined if the budget does not reach for all.
    std::ranges::sort(wide);
    std::vector<CutNode> finer;
    for (const auto& [depth, i] : wide) {
      const CutNode& node = open_[i];
      // Once the budget is full all others stay coarse, also those that would fit: the cut is then
      // finest in front.
      if (!is_stopped_) {
        const std::vector<CutNode> children = childrenOf(node);
        for (const CutNode& child : children) countReading(child);
        remove(node);
        for (const CutNode& child : children) add(child);
        if (!fits()) {
          is_stopped_ = true;
        } else if (!comeInTime(children)) {
          awaits_data_ = true;
        } else {
          finer.insert(finer.end(), children.begin(), children.end());
          refined_.push_back(node);
          continue;
        }
        // The attempt is taken back.
        for (const CutNode& child : children) remove(child);
        add(node);
      }
      chosen_.push_back(node);
    }
    open_ = std::move(finer);
  }

  const CutOptions& options_;       // the volumes' but for the limits of bytes
  const PyramidLayout& pyramid_;    // of the first volume
  int levels_ = pyramid_.levels();  // that all volumes have in common
  const PixelSizes sizes_;
  bool holds_extremes_ = false;  // the coarser levels do
  std::vector<Volume> volumes_;
  std::vector<CutPart> parts_;
  std::vector<CutNode> open_, chosen_, refined_;
  bool is_stopped_ = false;
  bool awaits_data_ = false;  // a part stays coarse for want of time
  bool reads_any_ = false;    // a part was refined by blocks that are to be read
};

}  // namespace

std::vector<VisibleBlocks> makeCut(std::span<const BlockQuestion> questions,
                                   const std::vector<std::shared_ptr<ShownLevels>>& shown) {
  SLUICE_CHECK_EQ(questions.size(), shown.size());
  CutMaker maker(questions, shown);
  if (const std::optional<int> level = questions.front().cut->level)
    maker.makeLevel(*level);
  else
    maker.make();
  std::vector<VisibleBlocks> blocks;
  for (size_t i = 0; i < questions.size(); ++i) blocks.push_back(maker.result(i));
  return blocks;
}

}  // namespace sluice
