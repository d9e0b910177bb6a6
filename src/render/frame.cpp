// A frame, from the transfer function to the picture.
#include <algorithm>
#include <numeric>

#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/render/session.h"
#include "src/texture/requests.h"

namespace sluice {
namespace {

std::vector<int64_t> allBlocks(const TexturePlan& plan) {
  std::vector<int64_t> positions(plan.blocks.size());
  std::iota(positions.begin(), positions.end(), 0);
  return positions;
}

}  // namespace

Frame Session::frame() {
  try {
    return drawFrame();
  } catch (...) {
    // What was begun for this frame is not wanted any more, and its counters are to be right.
    ahead_.reset();
    chunks_.waitUntilIdle();
    throw;
  }
}

FrameReport Session::frameReport() {
  Frame drawn = frame();
  device_.reuse(std::move(drawn.picture));
  return drawn.report;
}

Frame Session::drawFrame() {
  SLUICE_CHECK(transfer_.has_value());
  Frame frame;
  FrameReport& report = frame.report;
  const Stopwatch watch;
  const auto begin = std::chrono::steady_clock::now();
  const StageSeconds before = workerSeconds();
  const MovedBytes moved_before = movedBytes();
  const uint64_t binds_before = device_.binds(), pages_before = cache_.pagesLoaded();

  // A frame that failed may have left some.
  pending_.boxes.clear();
  counted_.clear();

  classifyBlocks(report);
  planChunks(report);

  const View view = resolve(frame_options_.camera, source_.layout(), frame_options_.size,
                            frame_options_.step_vox);
  FrameSetup setup = frameSetup(view, source_.layout(), *table_, ranges_.map, frame_options_);
  setup.lit = options_.lit;
  setup.counts_taken = countsTaken();
  const EyePosition eye = eyePosition(view, source_.layout());
  device_.beginFrame(setup);
  startOcclusion(setup, eye);
  // All chunks at once, so that the picture's whole front comes first and hides what it can.
  const bool draws_whole =
      occlusion_ && plan_->pageCount() <= static_cast<int64_t>(cache_.capacityPages());
  ahead_.emplace(chunks_, *plan_, names_, cache_, clusterOrder(*plan_, eye), chunkNeeds());
  cache_.unpinAll();
  while (const auto taken = ahead_->take(deadline(begin))) {
    throwIfInterrupted();
    makeResident(*taken, report);
    if (!taken->step.completes_cluster || draws_whole) continue;
    const Cluster& cluster = plan_->clusters[static_cast<size_t>(taken->step.cluster)];
    drawBlocks(
        occlusion_ ? layerOrder(*plan_, cluster.blocks, eye) : blockOrder(*plan_, cluster, eye),
        eye, report);
    cache_.unpinAll();
  }
  if (draws_whole) drawBlocks(layerOrder(*plan_, allBlocks(*plan_), eye), eye, report);
  const Stopwatch draw_watch;
  frame.picture = device_.endFrame();
  report.stages.draw += draw_watch.seconds();
  finishOcclusion(report);

  report.seconds = watch.seconds();
  const StageSeconds after = workerSeconds();
  report.stages.read = after.read - before.read;
  report.stages.decode = after.decode - before.decode;
  report.stages.copy = after.copy - before.copy;
  const MovedBytes moved = movedBytes();
  report.decoded_bytes = moved.decoded - moved_before.decoded;
  report.copied_bytes = moved.copied - moved_before.copied;
  report.uploaded_bytes = moved.uploaded - moved_before.uploaded;
  report.binds = device_.binds() - binds_before;
  report.pages_loaded = cache_.pagesLoaded() - pages_before;
  report.before = last_blocks_;
  last_blocks_ = {report.white, report.grey, report.black};
  last_draw_s_ = report.stages.draw;
  ++frame_number_;
  if (report.missing_share > 0) {
    double cells = 0;
    for (const TextureBlock& block : plan_->blocks)
      cells += static_cast<double>(block.cells.count());
    report.missing_share /= cells;
  } else {
    ahead_.reset();
  }
  if (frame_options_.count_samples) countSamples(report);
  if (!phases_.empty()) frame.phases = drawPhases(setup);
  return frame;
}

void Session::classifyBlocks(FrameReport& report) {
  const Stopwatch watch;
  if (!table_) {
    TransferFunction shown = *transfer_;
    if (frame_options_.mode != Mode::kComposite) shown.gradients.clear();
    table_.emplace(shown, ranges_.map, ranges_.device_range);
  }
  if (!classification_) {
    classification_ = classify(ranges_, *table_, crop(), pool_);
    dropPlan();
  }
  report.white = classification_->white;
  report.grey = classification_->grey;
  report.black = classification_->black;
  report.stages.classify = watch.seconds();
}

void Session::planChunks(FrameReport& report) {
  const Stopwatch watch;
  if (!plan_) {
    plan_ = planTextures(ranges_.layout, *classification_, options_.page,
                         {frame_options_.algorithm, frame_options_.merge_order, time_, crop()});
    names_ = chunk_names_.namesOf(*plan_);
    for (uint64_t& name : names_) name += first_id_;
  }
  report.clusters = static_cast<int64_t>(plan_->clusters.size());
  report.chunks = static_cast<int64_t>(plan_->chunks.size());
  report.pages = plan_->pageCount();
  report.rebuild = rebuildBytes();
  report.stages.plan = watch.seconds();
}

void Session::makeResident(const ReadAhead::Taken& taken, FrameReport& report) {
  for (size_t i = 0; i < taken.texels.size(); ++i) {
    const int64_t position = taken.step.chunks[i];
    ChunkTexelsPtr texels = taken.texels[i];
    // The texels come first: a chunk that cannot be read is one that the model was never asked for.
    if (texels == nullptr && !cache_.contains(names_[static_cast<size_t>(position)])) {
      if (frame_options_.time_limit_s) continue;
      texels = ahead_->takeOne(position);
    }
    requestChunk(position, taken.step.cluster, texels.get(), report);
  }
}

void Session::requestChunk(int64_t position, int64_t cluster_position, const ChunkTexels* texels,
                           FrameReport& report) {
  const Chunk& chunk = plan_->chunks[static_cast<size_t>(position)];
  const uint64_t name = names_[static_cast<size_t>(position)];
  if (trace_ != nullptr)
    trace_->write(requestFor(*plan_, position, name - first_id_, cluster_position, frame_number_));
  // The model decides, the device obeys (design, point 5).
  const TextureCache::Answer answer = cache_.request(name, static_cast<uint32_t>(chunk.pages),
                                                     TextureBuffer::bytesOf(*plan_, chunk));
  if (answer.outcome == Outcome::kDoesNotFit)
    fail("a cluster needs more than the texture cache's {} pages; give more --pages",
         cache_.capacityPages());
  cache_.pin(name);
  for (const uint64_t evicted : answer.evicted) device_.evict(evicted);
  if (answer.outcome != Outcome::kLoaded) return;
  SLUICE_CHECK(texels != nullptr);
  const Stopwatch watch;
  try {
    device_.makeResident(name, texels->storage_vox, ranges_.map.type, texels->span());
  } catch (...) {
    cache_.erase(name);
    throw;
  }
  report.stages.upload += watch.seconds();
}

void Session::drawBlocks(std::span<const int64_t> order, const EyePosition& eye,
                         FrameReport& report) {
  const Stopwatch watch;
  const double boxes_before = report.stages.boxes;
  for (const int64_t position : order) {
    const TextureBlock& block = plan_->blocks[static_cast<size_t>(position)];
    if (block.cells.empty()) continue;  // loaded whole, shows nothing (algorithm II)
    if (occlusion_ && occlusion_->hides(block.cells)) {
      occlusion_->leaveOut(block.cells.count());
      continue;
    }
    if (!cache_.contains(names_[static_cast<size_t>(block.chunk)])) {  // left out at the time limit
      report.missing_share += static_cast<double>(block.cells.count());
      if (occlusion_) shown_[static_cast<size_t>(block.chunk)] = true;  // the next frame wants it
      continue;
    }
    drawBlock(position, eye, report);
  }
  flushBoxes(report);
  report.stages.draw += watch.seconds() - (report.stages.boxes - boxes_before);
}

void Session::drawBlock(int64_t position, const EyePosition& eye, FrameReport& report) {
  const TextureBlock& block = plan_->blocks[static_cast<size_t>(position)];
  BoxDraw box = boxDraw(block);
  if (frame_options_.partition == Partition::kBlocks) {
    drawBox(block.chunk, box, report);
    return;
  }
  const Stopwatch watch;
  const std::shared_ptr<const DrawnBoxes> drawn = drawnBoxes(position);
  report.stages.boxes += watch.seconds();
  if (drawn == nullptr) {  // the object box holds whatever its boxes would show
    drawBox(block.chunk, box, report);
    return;
  }
  const Vec3i first = ranges_.layout.ownedCells(ranges_.layout.indexOf(block.block)).lo;
  const BoxEye from{eye.parallel, eye.parallel ? eye.index : eye.index - toDouble(first)};
  drawn->visitFrontToBack(from, [&](const Box3& local) {
    box.cells = translate(local, first);
    drawBox(block.chunk, box, report);
  });
}

void Session::drawBox(int64_t chunk, BoxDraw box, FrameReport& report) {
  if (occlusion_) {
    const std::optional<Box3> visible = occlusion_->visible(box.cells);
    if (!visible) return;
    box.cells = *visible;
    shown_[static_cast<size_t>(chunk)] = true;
  }
  if (chunk != pending_.chunk) flushBoxes(report);
  pending_.chunk = chunk;
  pending_.boxes.push_back(box);
  if (occlusion_ && occlusion_->isUpdateDue()) updateOpacityMap(report);
}

void Session::flushBoxes(FrameReport& report) {
  if (pending_.boxes.empty()) return;
  device_.draw(names_[static_cast<size_t>(pending_.chunk)], pending_.boxes);
  report.boxes_drawn += static_cast<int64_t>(pending_.boxes.size());
  if (!phases_.empty()) phases_.back().drawn.push_back(pending_);
  if (frame_options_.count_samples)
    counted_.insert(counted_.end(), pending_.boxes.begin(), pending_.boxes.end());
  pending_.boxes.clear();
}

void Session::countSamples(FrameReport& report) {
  std::vector<BoxDraw> object;
  for (const ObjectBlock& block : classification_->visible) {
    BoxDraw box;
    box.cells = block.cells;
    object.push_back(box);
  }
  // Before the other counts, which use the same place.
  const uint64_t taken = countsTaken() ? device_.takenSamples() : 0;
  report.samples_drawn = device_.countSamples(counted_);
  report.samples_taken = countsTaken() ? taken : report.samples_drawn;
  report.samples_object = device_.countSamples(object);
  counted_.clear();
}

}  // namespace sluice
