#include "src/render/frame/refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/blocks/cut/cut_rules.h"

namespace sluice {
namespace {

// A picture that reads less than so many times the last one's bytes shows little more.
constexpr double kLeastGain = 1.25;
// The share of the time left that a picture may take by what the last one predicts, which is often
// too much. A picture that is not whole in time only costs the time that is left anyway.
constexpr double kPlannedShare = 1.2;
// Coarse pictures take so little that their time says nothing of bytes: blocks come at least as
// fast as this.
constexpr double kLeastBytesPerSecond = 150e6;

// A small last pixel error is reached in more steps than there are levels. Steps that make the same
// cut cost little.
constexpr int kMorePixelErrors = 6;

// Cuts from the coarsest of so many levels to `last`, each about a level finer than the one before.
// `named`: the number of levels of which `last` may name one.
std::vector<CutOptions> cutsTo(const CutOptions& last, int levels, int named) {
  std::vector<CutOptions> cuts;
  const int finer_steps = last.level ? levels - 1 - *last.level : levels + kMorePixelErrors + 1;
  CutOptions cut = last;
  for (int finer = finer_steps; finer > 0; --finer) {
    if (last.level) cut.level = std::min(*last.level + finer, named - 1);
    // The first cut is the coarsest that there is, whatever the pixel error.
    cut.pixel_error = finer == finer_steps ? std::numeric_limits<double>::infinity()
                                           : std::ldexp(last.pixel_error, finer);
    cuts.push_back(cut);
  }
  cuts.push_back(last);
  return cuts;
}

bool isFinest(const VisibleBlocks& blocks) {
  return std::ranges::all_of(blocks.cut->levels,
                             [](const CutSummary::Level& level) { return level.level == 0; });
}

uint64_t voxelBytes(const VisibleBlocks& blocks, const TimeStep& step) {
  const PyramidLayout pyramid = step.layout();
  const VoxelType type = step.source->layout().type;
  // Voxels count as the volume stores them, since CutOptions::most_stored_bytes limits these bytes.
  uint64_t bytes = 0;
  for (const ObjectBlock& block : blocks.blocks)
    bytes += static_cast<uint64_t>(pyramid.storedVoxels(block.name).count()) *
             storedBytesPerVoxel(type, pyramid.of(block.name).numbers);
  return bytes;
}

}  // namespace

Refinement::Refinement(const std::vector<RefinedLayer>& layers, RefinedPainter painter,
                       const FrameOptions& frame, std::optional<Deadline::TimePoint> until,
                       WorkerPool& pool)
    : painter_(std::move(painter)), frame_(frame), deadline_(until, frame.stop) {
  int most_levels = 1;
  for (size_t i = 0; i < layers.size(); ++i) {
    const RefinedLayer& of = layers[i];
    SLUICE_CHECK(!until || !of.ends_uncut);
    const FrameOptions own = painter_.options_of(i, frame);
    auto layer = std::make_unique<Layer>(Layer{of, false, nullptr, LevelCut(pool), nullptr, 0});
    layer->has_cut = drawsCut(of.step, own.cut, own.mode, of.transfer);
    layer->look = std::make_shared<const Look>(makeLook(of.step, of.transfer, own.mode));
    if (layer->has_cut) most_levels = std::max(most_levels, of.step.layout().levels());
    layers_.push_back(std::move(layer));
  }
  const PyramidLayout first = layers.front().step.layout();
  int named = first.levels();
  // Layers that are drawn as one medium have one cut, through the levels that all of them have.
  if (painter_.is_one_medium) {
    for (const RefinedLayer& layer : layers)
      named = std::min(named, levelsInCommon(first, layer.step.layout()));
    most_levels = std::min(most_levels, named);
  }
  SLUICE_CHECK(most_levels > 1);
  cuts_ = cutsTo(*frame.cut, most_levels, named);
}

Refinement::~Refinement() {
  chooseAsBefore();
}

void Refinement::chooseAsBefore() {
  for (const auto& layer : layers_) layer->of.session.chooseBlocksBy(nullptr);
}

Refinement::Planned Refinement::plan(const CutOptions& cut, const double* growth) {
  const bool is_last = tried_ + 1 == cuts_.size();
  const auto endsUncut = [&](const std::unique_ptr<Layer>& layer) {
    return is_last && layer->of.ends_uncut;
  };
  const bool any_uncut = std::ranges::any_of(layers_, endsUncut);
  Planned planned;
  planned.options = frame_;
  planned.options.time_limit_s.reset();
  if (any_uncut)
    planned.options.cut.reset();
  else
    planned.options.cut = cut;
  // Slices follow the cut, so that a coarse picture takes few samples.
  planned.options.step_vox = painter_.step_of(planned.options.cut);
  FrameOptions with_cut = planned.options;
  with_cut.cut = cut;
  for (size_t i = 0; i < layers_.size(); ++i) {
    Part& part = planned.parts.emplace_back();
    part.options = painter_.options_of(i, with_cut);
    if (endsUncut(layers_[i]) || (any_uncut && painter_.is_one_medium)) part.options.cut.reset();
  }
  choose(planned);
  if (growth == nullptr) return planned;
  bool is_less = false;
  for (size_t i = 0; i < layers_.size(); ++i) {
    const Layer& layer = *layers_[i];
    Part& part = planned.parts[i];
    // A layer that reads no more than for the last picture needs no limit.
    if (part.blocks == nullptr || part.bytes <= layer.bytes) continue;
    const auto more = static_cast<double>(part.bytes - layer.bytes);
    uint64_t& most = part.options.cut->most_stored_bytes;
    // Each layer gets the same share of what it would grow by.
    most = std::min(most, layer.bytes + static_cast<uint64_t>(*growth * more));
    is_less = true;
  }
  if (is_less) choose(planned);
  return planned;
}

void Refinement::choose(Planned& planned) {
  std::vector<size_t> with_cut;
  std::vector<LevelCut*> cuts;
  std::vector<BlockQuestion> questions;
  for (size_t i = 0; i < layers_.size(); ++i) {
    Layer& layer = *layers_[i];
    const FrameOptions& options = planned.parts[i].options;
    if (!layer.has_cut || !options.cut) continue;
    const VolumeLayout& layout = layer.of.step.source->layout();
    const View view = resolve(options, layout);
    questions.push_back(
        {layer.of.step, layer.look, cropCells(options, layout.dims), view, options.cut});
    cuts.push_back(&layer.chooser);
    with_cut.push_back(i);
  }
  std::vector<VisibleBlocksPtr> chosen;
  if (painter_.is_one_medium)
    chosen = LevelCut::chooseTogether(cuts, questions);
  else
    for (size_t k = 0; k < cuts.size(); ++k) chosen.push_back(cuts[k]->choose(questions[k]));
  planned.bytes = 0;
  for (size_t k = 0; k < cuts.size(); ++k) {
    Part& part = planned.parts[with_cut[k]];
    part.blocks = chosen[k];
    part.bytes = voxelBytes(*part.blocks, layers_[with_cut[k]]->of.step);
    planned.bytes += part.bytes;
  }
}

bool Refinement::showsAsLast(const Planned& planned) const {
  for (size_t i = 0; i < layers_.size(); ++i) {
    const VisibleBlocksPtr &now = planned.parts[i].blocks, &before = layers_[i]->blocks;
    // Without a cut, the finest level looks the same but for samples and light that look around.
    const FrameOptions& options = planned.parts[i].options;
    const bool is_finest = now == nullptr && before != nullptr && !options.integrates &&
                           !options.lighting.looksAround() && isFinest(*before);
    if (now != before && !is_finest) return false;
  }
  return true;
}

void Refinement::skipSame() {
  // A finer pixel error that makes the same cut shows the same picture again.
  for (; !isLast(); ++tried_) {
    const Planned planned = plan(cuts_[tried_]);
    if (!showsAsLast(planned) || planned.options.step_vox != shown_.step_vox) return;
  }
}

// The next picture that differs from the last one, within the time that is left.
std::optional<Refinement::Planned> Refinement::better() {
  if (isLast()) return std::nullopt;
  Planned planned = plan(cuts_[tried_]);
  const std::optional<double> left_s = deadline_.secondsLeft();
  // The first picture is drawn whatever it takes, and without a limit all are.
  if (!has_picture_ || !left_s) return planned;
  // Rays take as many more samples as their slices are closer; the rest follows the bytes.
  const double draw_s = draw_s_ * shown_.step_vox / planned.options.step_vox;
  const double rest_s = std::max(0.0, frame_s_ - draw_s_);
  const auto bytes = static_cast<double>(bytes_);
  const double bytes_per_s = std::max(bytes / std::max(rest_s, 1e-6), kLeastBytesPerSecond);
  const double may_take = bytes + (kPlannedShare * *left_s - draw_s - rest_s) * bytes_per_s;
  if (static_cast<double>(planned.bytes) <= may_take) return planned;
  is_over_ = true;
  if (may_take < kLeastGain * bytes) return std::nullopt;
  // Refines as far as the time seems to allow. A cut of one level alone takes no limit.
  if (cuts_[tried_].level) return std::nullopt;
  const double growth = (may_take - bytes) / (static_cast<double>(planned.bytes) - bytes);
  planned = plan(cuts_[tried_], &growth);
  if (showsAsLast(planned)) return std::nullopt;
  return planned;
}

std::optional<Frame> Refinement::next() {
  if (is_over_ || (has_picture_ && deadline_.isOver())) return std::nullopt;
  std::optional<Planned> planned = better();
  if (!planned) return std::nullopt;
  for (size_t i = 0; i < layers_.size(); ++i) {
    Session& session = layers_[i]->of.session;
    Part& part = planned->parts[i];
    // The first picture is drawn whole even if there is no time for it.
    part.options.stop = has_picture_ ? deadline_.token() : frame_.stop;
    session.setOptions(part.options);
    session.chooseBlocksBy(part.blocks != nullptr ? &part : nullptr);
  }
  const Stopwatch watch;
  std::optional<Frame> frame;
  try {
    frame = painter_.draw();
  } catch (const Interrupted&) {
    // A stop on the way ends the row with the last whole picture, unless the caller asked to stop.
    chooseAsBefore();
    if (!has_picture_ || deadline_.isStopped()) throw;
    is_over_ = true;
    return std::nullopt;
  }
  chooseAsBefore();
  frame_s_ = watch.seconds();
  // The stages of several layers may add up to more than the frame.
  draw_s_ = std::min(frame_s_, frame->report.stages.draw);
  for (size_t i = 0; i < layers_.size(); ++i) {
    layers_[i]->blocks = planned->parts[i].blocks;
    layers_[i]->bytes = planned->parts[i].bytes;
  }
  bytes_ = planned->bytes;
  shown_ = planned->options;
  has_picture_ = true;
  ++tried_;
  skipSame();
  return frame;
}

}  // namespace sluice
