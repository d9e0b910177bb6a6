// A frame, from the transfer function to the picture.
#include <algorithm>

#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/render/session.h"
#include "src/texture/requests.h"

namespace sluice {

Frame Session::frame() {
  SLUICE_CHECK(transfer_.has_value());
  Frame frame;
  FrameReport& report = frame.report;
  const Stopwatch watch;
  const StageSeconds before = workerSeconds();
  const uint64_t uploaded_before = device_.uploadedBytes(), binds_before = device_.binds();
  const uint64_t pages_before = cache_.pagesLoaded();

  classifyBlocks(report);
  planChunks(report);

  const View view = resolve(frame_options_.camera, source_.layout(), frame_options_.size,
                            frame_options_.step_vox);
  FrameSetup setup = frameSetup(view, source_.layout(), *table_, ranges_.map, frame_options_);
  setup.lit = options_.lit;
  const EyePosition eye = eyePosition(view, source_.layout());
  device_.beginFrame(setup);
  for (const int64_t position : clusterOrder(*plan_, eye)) {
    throwIfInterrupted();
    const Cluster& cluster = plan_->clusters[static_cast<size_t>(position)];
    makeResident(position, report);
    drawCluster(cluster, eye, report);
  }
  const Stopwatch draw_watch;
  frame.picture = device_.endFrame();
  report.stages.draw += draw_watch.seconds();

  report.seconds = watch.seconds();
  const StageSeconds after = workerSeconds();
  report.stages.read = after.read - before.read;
  report.stages.decode = after.decode - before.decode;
  report.stages.copy = after.copy - before.copy;
  report.uploaded_bytes = device_.uploadedBytes() - uploaded_before;
  report.binds = device_.binds() - binds_before;
  report.pages_loaded = cache_.pagesLoaded() - pages_before;
  ++frame_number_;
  if (frame_options_.count_samples) countSamples(report);
  return frame;
}

void Session::classifyBlocks(FrameReport& report) {
  const Stopwatch watch;
  if (!table_) table_.emplace(*transfer_, ranges_.map, ranges_.device_range);
  if (!classification_) {
    classification_ = classify(ranges_, *table_, crop(), pool_);
    plan_.reset();
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
  report.stages.plan = watch.seconds();
}

void Session::makeResident(int64_t cluster_position, FrameReport& report) {
  const Cluster& cluster = plan_->clusters[static_cast<size_t>(cluster_position)];
  cache_.unpinAll();
  // In batches that leave level 3 room to keep what other clusters filled. The texels come first:
  // a chunk that cannot be read is one that the model was never asked for.
  const uint64_t most = std::max<uint64_t>(1, budgets_.texture_buffer / 2);
  for (size_t from = 0; from < cluster.chunks.size();) {
    std::vector<int64_t> absent;
    uint64_t bytes = 0;
    size_t to = from;
    for (; to < cluster.chunks.size() && bytes < most; ++to) {
      const int64_t position = cluster.chunks[to];
      if (cache_.contains(names_[static_cast<size_t>(position)])) continue;
      absent.push_back(position);
      bytes += TextureBuffer::bytesOf(*plan_, plan_->chunks[static_cast<size_t>(position)]);
    }
    const std::vector<ChunkTexelsPtr> texels = chunks_.acquire(*plan_, names_, absent);
    for (size_t next = 0; from < to; ++from) {
      const int64_t position = cluster.chunks[from];
      const bool has_texels = next < absent.size() && absent[next] == position;
      // A load of this batch may have taken its pages: then it opens the next batch.
      if (!has_texels && !cache_.contains(names_[static_cast<size_t>(position)])) break;
      requestChunk(position, cluster_position, has_texels ? texels[next++].get() : nullptr, report);
    }
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

void Session::drawCluster(const Cluster& cluster, const EyePosition& eye, FrameReport& report) {
  const Stopwatch watch;
  std::vector<BoxDraw> boxes;  // that follow each other in one chunk
  int64_t chunk = -1;
  const auto flush = [&] {
    if (!boxes.empty()) device_.draw(names_[static_cast<size_t>(chunk)], boxes);
    boxes.clear();
  };
  for (const int64_t position : blockOrder(*plan_, cluster, eye)) {
    const TextureBlock& block = plan_->blocks[static_cast<size_t>(position)];
    if (block.cells.empty()) continue;  // loaded whole, shows nothing (algorithm II)
    if (block.chunk != chunk) flush();
    chunk = block.chunk;
    boxes.push_back(boxDraw(block));
  }
  flush();
  report.stages.draw += watch.seconds();
}

void Session::countSamples(FrameReport& report) {
  std::vector<BoxDraw> drawn, object;
  for (const TextureBlock& block : plan_->blocks)
    if (!block.cells.empty()) drawn.push_back(boxDraw(block));
  for (const ObjectBlock& block : classification_->visible) {
    BoxDraw box;
    box.cells = block.cells;
    object.push_back(box);
  }
  report.samples_drawn = device_.countSamples(drawn);
  report.samples_object = device_.countSamples(object);
}

}  // namespace sluice
