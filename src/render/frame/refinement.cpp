#include "src/render/frame/refinement.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"

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

// Cuts from the coarsest level to `last`, each about a level finer than the one before.
std::vector<CutOptions> cutsTo(const CutOptions& last, int levels) {
  std::vector<CutOptions> cuts;
  CutOptions cut = last;
  if (last.level) {
    for (int level = levels - 1; level > *last.level; --level) {
      cut.level = level;
      cuts.push_back(cut);
    }
  } else {
    cut.pixel_error = std::numeric_limits<double>::infinity();
    cuts.push_back(cut);
    for (int finer = levels + kMorePixelErrors; finer > 0; --finer) {
      cut.pixel_error = last.pixel_error * static_cast<double>(int64_t{1} << finer);
      cuts.push_back(cut);
    }
  }
  cuts.push_back(last);
  return cuts;
}

uint64_t voxelBytes(const VisibleBlocks& blocks, const TimeStep& step) {
  const PyramidLayout pyramid = step.layout();
  const VoxelType type = step.source->layout().type;
  uint64_t bytes = 0;
  for (const ObjectBlock& block : blocks.blocks)
    bytes += static_cast<uint64_t>(pyramid.storedVoxels(block.name).count()) *
             storedBytesPerVoxel(type, pyramid.of(block.name).numbers);
  return bytes;
}

}  // namespace

Refinement::Refinement(Session& session, const RefinedVolume& volume, const FrameOptions& frame,
                       StepOf step_of, std::optional<Deadline::TimePoint> until)
    : session_(session),
      volume_(volume),
      frame_(frame),
      step_of_(std::move(step_of)),
      look_(std::make_shared<const Look>(makeLook(volume.step, volume.transfer, frame.mode))),
      chooser_(volume.pool),
      deadline_(until, frame.stop),
      cuts_(cutsTo(*frame.cut, volume.step.layout().levels())) {
  SLUICE_CHECK(volume.step.layout().levels() > 1);
}

Refinement::~Refinement() {
  session_.chooseBlocksBy(nullptr);
}

Refinement::Planned Refinement::plan(const CutOptions& cut) {
  Planned planned;
  planned.options = frame_;
  planned.options.time_limit_s.reset();
  planned.options.cut = cut;
  planned.options.step_vox = step_of_(cut);
  const VolumeLayout& layout = volume_.step.source->layout();
  planned.blocks =
      chooser_.choose({volume_.step, look_, cropCells(frame_, layout.dims),
                       resolve(frame_.camera, layout, frame_.size, planned.options.step_vox), cut});
  planned.bytes = voxelBytes(*planned.blocks, volume_.step);
  return planned;
}

void Refinement::skipSame() {
  for (; !isLast(); ++tried_) {
    const Planned planned = plan(cuts_[tried_]);
    if (planned.blocks != blocks_ || planned.options.step_vox != shown_.step_vox) return;
  }
}

// The next picture that differs from the last one, within the time that is left.
std::optional<Refinement::Planned> Refinement::better() {
  if (isLast()) return std::nullopt;
  Planned planned = plan(cuts_[tried_]);
  const std::optional<double> left_s = deadline_.secondsLeft();
  if (blocks_ == nullptr || !left_s) return planned;
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
  CutOptions cut = cuts_[tried_];
  if (cut.level) return std::nullopt;
  cut.most_stored_bytes = std::min(cut.most_stored_bytes, static_cast<uint64_t>(may_take));
  planned = plan(cut);
  if (planned.blocks == blocks_) return std::nullopt;
  return planned;
}

std::optional<Frame> Refinement::next() {
  const bool is_first = blocks_ == nullptr;
  if (is_over_ || (!is_first && deadline_.isOver())) return std::nullopt;
  std::optional<Planned> planned = better();
  if (!planned) return std::nullopt;
  // The first picture is drawn whole even if there is no time for it.
  planned->options.stop = is_first ? frame_.stop : deadline_.token();
  session_.setOptions(planned->options);
  session_.chooseBlocksBy(&*planned);
  const Stopwatch watch;
  std::optional<Frame> frame;
  try {
    frame = session_.frame();
  } catch (const Interrupted&) {
    session_.chooseBlocksBy(nullptr);
    if (is_first || deadline_.isStopped()) throw;
    is_over_ = true;
    return std::nullopt;
  }
  session_.chooseBlocksBy(nullptr);
  frame_s_ = watch.seconds();
  draw_s_ = std::min(frame_s_, frame->report.stages.draw);
  bytes_ = planned->bytes;
  blocks_ = planned->blocks;
  shown_ = planned->options;
  ++tried_;
  skipSame();
  if (frame->report.cut && (is_over_ || !isLast())) frame->report.cut->is_final = false;
  return frame;
}

}  // namespace sluice
