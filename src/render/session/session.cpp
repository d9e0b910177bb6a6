#include "src/render/session/session.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/chunk_texels.h"
#include "src/device/pictures/added_frames.h"
#include "src/device/shading/look_up_texels.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/camera/pixel_sizes.h"
#include "src/render/frame/loaded_boxes.h"

namespace sluice {
namespace {

// Pictures with a shorter limit follow a hand: the next one shows another view.
constexpr double kSteady_s = 0.1;
// Reading fewer bytes says little of its speed.
constexpr uint64_t kTellingBytes = uint64_t{4} << 20;
// Reading that drawing hid took hardly any time. Memory is not faster than this.
constexpr double kMostBytes_s = 100e9;
constexpr double kMostBytes = 1e18;  // more than any volume has
constexpr double kNewSpeed = 0.5;    // weight of the last picture in the expected speed

}  // namespace

Session::Session(const TimeStep& step, Device& device, WorkerPool& pool,
                 const SessionOptions& options)
    : device_(device),
      pool_(pool),
      opened_with_(options),
      stale_check_(std::make_unique<StaleCheck>(step.source->layout().calledBy())),
      spreads_(std::make_unique<SpreadTally>()),
      lost_(std::make_unique<LostTally>()),
      learnt_(step.ranges->unknown.empty()
                  ? nullptr
                  : std::make_unique<LearntRanges>(step.time, step.ranges)),
      residency_(step, device, options, pool.threads(), options.trace_from.chunk),
      planner_(options.page, pool, residency_.names()),
      step_(step),
      frame_number_(options.trace_from.frame) {
  SLUICE_CHECK(!options.lit || step.ranges->layout.ghost >= 1);
  expectBlocksOf(step);
  // These parts are declared before residency_, so that they outlive its readers.
  residency_.blocks().checkBy(
      [check = stale_check_.get(), spreads = spreads_.get(), lost = lost_.get(),
       learnt = learnt_.get()](const BlockName& name, const VolumeBlock& block) {
        check->check(name, block);
        spreads->note(name, block);
        lost->note(name, block);
        if (learnt != nullptr) learnt->note(name, block);
      });
}

void Session::expectBlocksOf(const TimeStep& step) {
  stale_check_->expect({.time = step.time}, step.ranges);
  int32_t level = 0;
  for (const CoarserStep& coarser : step.coarser) {
    ++level;
    if (coarser.ranges != nullptr)
      stale_check_->expect({.time = step.time, .level = level}, coarser.ranges);
  }
}

std::shared_ptr<const SliceRanges> Session::learntRanges() const {
  return learnt_ != nullptr ? learnt_->ranges() : nullptr;
}

std::shared_ptr<const SliceRanges> Session::ranges() const {
  // Only the step that the session began with had unknown ranges to learn.
  return learnt_ != nullptr && learnt_->time() == step_.time ? learnt_->ranges() : step_.ranges;
}

void Session::setTimeStep(const TimeStep& step) {
  SLUICE_CHECK(step.source == step_.source);
  SLUICE_CHECK(step.ranges->layout.size == step_.ranges->layout.size);
  SLUICE_CHECK(step.ranges->layout.ghost == step_.ranges->layout.ghost);
  SLUICE_CHECK(step.layout() == step_.layout());
  SLUICE_CHECK_EQ(step.coarser.size(), step_.coarser.size());
  expectBlocksOf(step);
  step_ = step;
  lessons_.unfinished.reset();
}

void Session::setTransferFunction(TransferFunction transfer) {
  SLUICE_CHECK(transfer.gradients.empty() || step_.ranges->layout.ghost >= 1);
  transfer_ = std::make_shared<const TransferFunction>(std::move(transfer));
  lessons_.unfinished.reset();  // data that only the last picture needed is not read any more
}

void Session::takeLearntRanges() {
  auto known = ranges();
  if (known == step_.ranges) return;
  step_.ranges = std::move(known);
  expectBlocksOf(step_);
}

std::optional<FrameReport> Session::withoutBlocks() {
  SLUICE_CHECK(transfer_ != nullptr);
  if (options_.time_limit_s) return std::nullopt;  // its cut depends on the time
  const Stopwatch watch;
  takeLearntRanges();
  const LookPtr look = planner_.look(step_, transfer_, options_.mode);
  const View view = resolve(options_, step_.source->layout());
  const VisibleBlocksPtr visible =
      planner_.visibleBlocks(Planner::question(step_, look, view, options_));
  if (!visible->blocks.empty()) return std::nullopt;
  visible_ = visible;
  FrameReport report = reportWithoutBlocks(*visible, options_.step_vox);
  report.seconds = report.stages.classify = watch.seconds();
  return report;
}

bool Session::canDrawAtEnd() {
  const FrameOptions& asked = options_;
  if (asked.time_limit_s || asked.count_samples || asked.with_depth || afterwards_ ||
      asked.mode != Mode::kComposite || asked.occlusion != Occlusion::kOff ||
      asked.partition != Partition::kBlocks || asked.lighting.looksAround())
    return false;
  takeLearntRanges();
  const LookPtr look = planner_.look(step_, transfer_, asked.mode);
  const View view = resolve(asked, step_.source->layout());
  if (planner_.makesCut(step_, look, asked) || Planner::drawsSurfaces(step_, *look, asked) ||
      Planner::integrates(step_, *look, view, asked))
    return false;
  const VisibleBlocksPtr visible =
      planner_.visibleBlocks(Planner::question(step_, look, view, asked));
  const FramePlanPtr plan = planner_.plan(step_, visible, asked);
  return plan->textures.blocks.size() <= AddsFrames::kMostBoxesOfAFrame &&
         std::ranges::all_of(plan->names,
                             [&](ChunkName name) { return residency_.isResident(name); });
}

void Session::readAfterwards(const TimeStep& next) {
  const VolumeLayout& volume = next.source->layout();
  const View view = resolve(options_, volume);
  // The planner keeps these for the frame that will ask for the same.
  const LookPtr look = planner_.look(next, transfer_, options_.mode);
  const VisibleBlocksPtr visible =
      planner_.visibleBlocks(Planner::question(next, look, view, options_));
  const FramePlanPtr plan = planner_.plan(next, visible, options_);
  const DrawOrderPtr order = planner_.order(plan, eyePosition(view, volume), Arrangement::kRows);
  read_afterwards_ = std::make_unique<ReadAhead>(
      residency_, plan, *order, ReadPurpose{std::make_shared<ReadTally>(), options_.stop});
  read_afterwards_->begin();
}

std::optional<ReadLimit> Session::readLimit(const LookPtr& look) const {
  if (!options_.time_limit_s || !planner_.makesCut(step_, look, options_)) return std::nullopt;
  const double limit_s = *options_.time_limit_s;
  // At least half of the limit goes to reading, so that a slow last picture does not keep the next
  // one coarse.
  const double reading_s = std::max(limit_s - lessons_.draw_s, limit_s / 2);
  ReadLimit limit;
  limit.most_bytes = static_cast<uint64_t>(std::min(reading_s * bytes_per_s_, kMostBytes));
  limit.refines_some = limit_s >= kSteady_s;
  limit.keeps_refined = limit_s < kSteady_s;
  limit.last = drawn_;
  limit.is_in_memory = [this](const BlockName& name) {
    // The last picture's blocks count as there: its chunks are, even if level 2 has dropped the
    // blocks.
    return residency_.blocks().holds(name) ||
           (drawn_ != nullptr &&
            std::ranges::binary_search(drawn_->blocks, name, {}, &ObjectBlock::name));
  };
  return limit;
}

double Session::stepForCut(const VisibleBlocks& visible, const FrameOptions& options) const {
  // Only a cut that waits for data takes wider steps: the last picture of a row is the one without
  // a limit.
  if (!options.step_follows_cut || !visible.cut || !visible.cut->will_improve ||
      visible.cut->levels.empty())
    return options.step_vox;
  const View view = resolve(options, step_.source->layout());
  // Slices move apart as much as the voxels shown are wider than those that will be shown.
  const int wanted = finestLevelShown(step_, view, *options.cut);
  const int shown = std::max(wanted, visible.cut->levels.front().level);
  return options.step_vox * spacingOfLevel(step_, shown) / spacingOfLevel(step_, wanted);
}

void Session::noteDrawn(const VisibleBlocksPtr& visible, double reading_s, uint64_t read_bytes,
                        FrameReport& report) {
  drawn_ = visible->cut ? visible : nullptr;
  if (report.cut) {
    const ValueMap& map = step_.ranges->map;
    // The spread of a label is the share of other labels, whatever the scale of the values.
    const bool are_shares = report.cut->values == LevelValues::kModes;
    report.cut->spread = spreads_->of(*visible, are_shares ? 1 / wholeShare(map.type) : map.scale);
  }
  ++frame_number_;
  if (read_bytes < kTellingBytes || reading_s <= 0) return;
  const double bytes_per_s = std::min(static_cast<double>(read_bytes) / reading_s, kMostBytes_s);
  bytes_per_s_ += kNewSpeed * (bytes_per_s - bytes_per_s_);
}

bool Session::judgesSurfaces(const LookPtr& look, const FrameOptions& options) const {
  return Planner::drawsSurfaces(step_, *look, options) &&
         drawsCut(step_, options.cut, options.mode, look->transfer);
}

bool Session::losesSurface(const ObjectBlock& object, ReadTally& tally) {
  if (const std::optional<bool> known = lost_->known(object.name)) return *known;
  const std::span<const BlockName> name(&object.name, 1);
  return lost_->judge(object, *residency_.blocks().acquire(name, {}, &tally).front());
}

void Session::countLost(const Look& look, const VisibleBlocks& visible, const View& view,
                        ReadTally& tally, FrameReport& report) {
  const PyramidLayout pyramid = step_.layout();
  const PixelSizes sizes(step_.source->layout(), view);
  // Parts that show around the surfaces may be thin, too.
  const bool may_clear = !showsOpacities(*look.look_up);
  int64_t change = 0;
  for (const ObjectBlock& block : visible.blocks) {
    const BlockName& name = block.name;
    if (name.level == 0 || !(sizes.of(pyramid.of(name), pyramid.regionOf(name)) > 0)) continue;
    // Blocks that earlier frames read for other surfaces are judged if that needs no reading.
    if (!lost_->known(name) && (options_.time_limit_s || !residency_.blocks().holds(name)))
      continue;
    const bool is_thin = std::ranges::binary_search(visible.thin, name);
    if (losesSurface(block, tally))
      change += is_thin ? 0 : 1;
    else
      change -= is_thin && may_clear ? 1 : 0;
  }
  report.cut->thin_change = change;
  report.cut->thin_blocks += change;
}

FrameReport Session::frameReport() {
  Frame drawn = frame();
  // The picture's memory serves the next one.
  device_.reuse(std::move(drawn.picture));
  return drawn.report;
}

ChosenBoxesPtr Session::boxesOf(const LookPtr& look, const FramePlanPtr& plan) {
  if (options_.partition == Partition::kBlocks) return nullptr;
  SLUICE_CHECK(opened_with_.partition == Partition::kBoxes);
  const Budgets& budgets = residency_.budgets();
  // Half of the boxes' budget is for trees of all boxes, half for the boxes chosen from them.
  const auto store = box_store_.of(step_, [&] {
    return std::make_shared<BoxStore>(*step_.source, opened_with_.index_places, step_.time,
                                      *step_.ranges, residency_.readers(), budgets.boxes / 2,
                                      budgets.growing, residency_.readPast());
  });
  return boxes_.of({step_, look, plan, options_.step_vox}, [&] {
    return std::make_shared<const ChosenBoxes>(step_, look, plan, options_.step_vox, store,
                                               budgets.boxes / 2);
  });
}

}  // namespace sluice
