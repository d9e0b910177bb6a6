#include "src/render/frame/frame_run.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/pictures/picture_rows.h"
#include "src/render/frame/level_borders.h"
#include "src/render/frame/loaded_boxes.h"
#include "src/texture/frame_trace.h"

namespace sluice {
namespace {

// A list for the device ends with the chunk that brings it to this.
constexpr size_t kMostBoxesAtOnce = 1 << 14;

void append(std::vector<BoxDraw>& to, const std::vector<BoxDraw>& boxes) {
  to.insert(to.end(), boxes.begin(), boxes.end());
}

}  // namespace

FrameRun::FrameRun(FrameValues values, Residency& residency, Device& device, TraceWriter* trace,
                   int64_t number, const FrameLessons& lessons)
    : values_(std::move(values)),
      options_(values_.options),
      residency_(residency),
      device_(device),
      trace_(trace),
      number_(number),
      last_(lessons),
      // The number of updates adapts to what one kind of occlusion hides. Another kind starts anew.
      updates_(lessons.occlusion == options_.occlusion ? lessons.updates
                                                       : UpdateCount(lessons.updates.options())) {
  if (values_.setup.has_surfaces) fades_ = LevelFades(values_.visible->seams);
}

FrameRun::~FrameRun() {
  if (!is_drawn_) {
    // Ends the reading that was begun for this frame, so that the levels' counters are right.
    boxes_.reset();
    ahead_.reset();
    residency_.chunks().waitUntilIdle();
  }
  // A frame that was drawn may be drawn again, phase after phase, and be stopped there.
  device_.cancelFrame();
}

Picture FrameRun::draw() {
  const FramePlan& plan = *values_.plan;
  device_.beginFrame(values_.setup, options_.stop);
  // Before the reading begins, which asks it what is hidden.
  startOcclusion();
  const ReadPurpose purpose{tally_, options_.stop};
  if (values_.boxes != nullptr) {
    boxes_.emplace(values_.boxes, *values_.order, residency_.readers(), !options_.time_limit_s,
                   purpose);
    boxes_->begin([this](BlockPosition block) { return isHidden(block); });
  }
  ahead_ = std::make_unique<ReadAhead>(residency_, values_.plan, *values_.order, purpose, needs());
  // A frame that was stopped may have left chunks pinned.
  residency_.unpinAll();
  const Deadline deadline = this->deadline();
  size_t visit = 0;
  bool is_read = false;
  const auto tellRead = [&] {
    if (!std::exchange(is_read, true) && values_.when_read) values_.when_read();
  };
  tellProgress(visit);
  while (const auto taken = ahead_->take(deadline)) {
    options_.stop.throwIfStopped();
    makeResident(*taken);
    // The last chunk of the frame is there: the readers are free for the next step.
    if (ahead_->isDone()) tellRead();
    // A cluster may take several steps. It is drawn when all of its chunks are there.
    if (!taken->step.completes_cluster) continue;
    const Visit& now = values_.order->visits[visit++];
    // A visit that does not draw leaves its chunks pinned for the one that does.
    if (now.draws) {
      drawBlocks(now.blocks);
      residency_.unpinAll();
    }
    tellProgress(visit);
  }
  tellRead();  // also of a frame that shows nothing
  const Stopwatch watch;
  Picture picture = device_.endFrame();
  report_.stages.draw += watch.seconds();
  if (missing_cells_ > 0) report_.missing_share = missing_cells_ / static_cast<double>(plan.cells);
  gatherCounters();
  boxes_.reset();
  is_drawn_ = true;
  return picture;
}

void FrameRun::tellProgress(size_t visits) const {
  if (options_.watch) options_.watch(visits, values_.order->visits.size());
  options_.stop.throwIfStopped();
}

FrameRun::Deadline FrameRun::deadline() const {
  if (!options_.time_limit_s) return std::nullopt;
  // Drawing is expected to take as long as in the last frame: only the rest of the limit is for
  // waiting.
  const std::chrono::duration<double> waiting(*options_.time_limit_s - last_.draw_s);
  return values_.asked_at + std::chrono::duration_cast<std::chrono::nanoseconds>(waiting);
}

void FrameRun::makeResident(const ReadAhead::Taken& taken) {
  const auto request = [&](ChunkPosition chunk, ChunkName name) {
    if (trace_ != nullptr)
      trace_->write(requestFor(textures(), chunk, name, taken.step.cluster, number_));
  };
  loadChunks(taken, *values_.plan, *ahead_, residency_, options_.time_limit_s.has_value(), report_,
             request);
}

void FrameRun::drawBlocks(const std::vector<BlockPosition>& order) {
  const Stopwatch watch;
  const double boxes_before = report_.stages.boxes;
  const std::optional<PictureRows> rows = rowsOf(device_);
  for (const BlockPosition position : order) {
    const TextureBlock& block = textures().blocks[position];
    if (block.cells.empty()) continue;  // loaded whole, shows nothing (algorithm II)
    // A device that draws strips skips blocks that none of its rows meets.
    if (rows && !overlap(*rows, rowsOf(values_.setup, reachOf(block)))) continue;
    if (isHidden(position)) {
      occlusion_->leaveOut(block.cells.count());
      continue;
    }
    if (!residency_.isResident(values_.plan->names[block.chunk])) {
      missing_cells_ += static_cast<double>(block.cells.count());  // left out at the time limit
      if (occlusion_) shown_[block.chunk] = true;                  // the next frame wants it
      continue;
    }
    drawBlock(position);
  }
  flushBoxes();
  report_.stages.draw += watch.seconds() - (report_.stages.boxes - boxes_before);
}

bool FrameRun::hasBorders(const TextureBlock& block) const {
  return block.level_faces != 0 && values_.setup.has_surfaces;
}

Box3 FrameRun::reachOf(const TextureBlock& block) const {
  return hasBorders(block) ? cellsWithBorders(textures().pyramid, block, values_.setup.shown)
                           : block.cells;
}

void FrameRun::drawBlock(BlockPosition position) {
  const TextureBlock& block = textures().blocks[position];
  BoxDraw box = boxDraw(textures(), block);
  VisibleBoxesPtr boxes;
  if (boxes_) {
    const Stopwatch watch;
    boxes = boxes_->take(position, [this](BlockPosition other) { return isHidden(other); });
    report_.stages.boxes += watch.seconds();
  }
  if (boxes == nullptr) {  // the object box holds whatever its boxes would show
    if (hasBorders(block) || textures().seamsOf(position) > 0)
      drawWithBorders(position, box);
    else
      drawBox(block.chunk, box);
    return;
  }
  const Vec3i first = values_.boxes->firstCell(position);
  const EyePosition& eye = values_.order->eye;
  // The boxes of a tree lie in cells of their block.
  const BoxEye from{eye.parallel, eye.parallel ? eye.index : eye.index - toDouble(first)};
  boxes->visitFrontToBack(from, [&](const Box3& local) {
    box.cells = translate(local, first);
    drawBox(block.chunk, box);
  });
}

void FrameRun::drawWithBorders(BlockPosition position, BoxDraw box) {
  const TextureBlock& block = textures().blocks[position];
  const Box3& shown = values_.setup.shown;
  const EyePosition& eye = values_.order->eye;
  const LevelBorders borders = levelBorders(textures().pyramid, block, box, fades_, shown, eye);
  std::vector<SeamBox> joined, before, behind;
  for (int64_t i = 1; i <= textures().seamsOf(position); ++i) {
    const TextureBlock& coarse = textures().blocks[BlockPosition(position.value() + i)];
    // It may be hidden, or missing at a time limit.
    if (!residency_.isResident(values_.plan->names[coarse.chunk])) continue;
    const LevelSeam& seam = fades_.seam(static_cast<size_t>(coarse.seam));
    BoxDraw rest = boxDraw(textures(), coarse);
    rest.fade = fades_.rest(seam);
    const SeamBoxes boxes = seamBoxes(seam, rest, box.cells, shown, eye);
    if (boxes.joined) joined.push_back({coarse.chunk, *boxes.joined});
    for (const BoxDraw& each : boxes.before) before.push_back({coarse.chunk, each});
    for (const BoxDraw& each : boxes.behind) behind.push_back({coarse.chunk, each});
  }
  for (const auto& [chunk, beyond] : before) drawBox(chunk, beyond);
  for (const BoxDraw& each : borders.before) drawBox(block.chunk, each);
  std::vector<Box3> seams;
  seams.reserve(joined.size());
  for (const SeamBox& each : joined) seams.push_back(each.box.cells);
  for (const SeamPart& part : partsAtSeams(box.cells, seams, eye)) {
    BoxDraw of_part = box;
    of_part.cells = part.cells;
    if (!part.seams.empty()) of_part.fade = fades_.within(block.name);
    std::vector<SeamBox> with;
    // A corner has more seams if levels halve some axes alone: those at faces come first.
    const size_t count = std::min(part.seams.size(), kMostJoined);
    for (const size_t seam : std::span(part.seams).first(count)) with.push_back(joined[seam]);
    drawBox(block.chunk, of_part, with);
  }
  for (const BoxDraw& each : borders.behind) drawBox(block.chunk, each);
  for (const auto& [chunk, beyond] : behind) drawBox(chunk, beyond);
}

void FrameRun::drawBox(ChunkPosition chunk, BoxDraw box, std::span<const SeamBox> joined) {
  if (occlusion_) {
    const std::optional<Box3> visible = occlusion_->visible(box.cells);
    if (!visible) return;
    box.cells = *visible;
    shown_[chunk] = true;
  }
  box.chunk = residency_.idOf(values_.plan->names[chunk]);
  // Boxes of one chunk follow each other in a list, so that the device binds it once.
  if (pending_.empty() || pending_.back().chunk != box.chunk) {
    if (pending_.size() >= kMostBoxesAtOnce) flushBoxes();
    ++report_.binds;
  }
  pending_.push_back(box);
  for (const auto& [of_chunk, rest] : joined) {
    BoxDraw part = rest;
    part.cells = intersect(rest.cells, box.cells);
    if (part.cells.empty()) continue;
    part.chunk = residency_.idOf(values_.plan->names[of_chunk]);
    if (occlusion_) shown_[of_chunk] = true;
    ++report_.binds;
    pending_.push_back(part);
  }
  // After the box is in the list, so that the map sees it.
  if (occlusion_ && occlusion_->isUpdateDue()) updateOpacityMap();
}

void FrameRun::flushBoxes() {
  if (pending_.empty()) return;
  device_.draw(pending_);
  if (!phases_.empty()) append(phases_.back().drawn, pending_);
  // Boxes beside others take no samples of opacities.
  std::erase_if(pending_, [](const BoxDraw& box) { return box.beside.has_value(); });
  report_.boxes_drawn += static_cast<int64_t>(pending_.size());
  if (options_.count_samples) append(counted_, pending_);
  pending_.clear();
}

void FrameRun::gatherCounters() {
  addCounts(*values_.visible, *values_.plan, *tally_, report_);
  report_.before = last_.blocks;
  if (!occlusion_) return;
  // The seconds are measured here, the occlusion counts the rest.
  const double seconds = report_.occlusion.seconds;
  report_.occlusion = occlusion_->report();
  report_.occlusion.seconds = seconds;
  report_.occlusion.chunks_hidden = std::count(shown_.begin(), shown_.end(), false);
}

void FrameRun::countSamples() {
  std::vector<BoxDraw> object;
  for (const ObjectBlock& block : values_.visible->blocks) {
    BoxDraw box;
    box.cells = block.cells;
    object.push_back(box);
  }
  // The taken samples are read first, because the other counts use the same place.
  const uint64_t taken = values_.setup.counts_taken ? device_.takenSamples() : 0;
  report_.samples_drawn = device_.countSamples(counted_);
  report_.samples_taken = values_.setup.counts_taken ? taken : report_.samples_drawn;
  report_.samples_object = device_.countSamples(object);
}

FrameLessons FrameRun::lessons() {
  FrameLessons next;
  next.blocks = report_.blocks;
  next.draw_s = report_.stages.draw;
  next.occlusion = options_.occlusion;
  next.updates = updates_;
  if (occlusion_) {
    next.updates.finished({occlusion_->hiddenShare(), report_.occlusion.updates});
    // The next frame of this plan knows which chunks it will not need.
    next.plan = values_.plan;
    next.shown = std::move(shown_);
  }
  // Reading of what is missing goes on until the next frame begins.
  if (report_.missing_share > 0) next.unfinished = std::move(ahead_);
  return next;
}

}  // namespace sluice
