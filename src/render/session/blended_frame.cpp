#include "src/render/session/blended_frame.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/pictures/picture_rows.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/frame/draw_order.h"
#include "src/render/frame/loaded_boxes.h"
#include "src/render/session/union_plan.h"
#include "src/texture/frame_trace.h"

namespace sluice {
namespace {

// A block's name without its time, which channels may have others of.
BlockName ofAnyTime(BlockName name) {
  name.time = 0;
  return name;
}

// The frame that all channels are drawn in.
struct SharedFrame {
  const TexturePlan& all;
  const DrawOrder& order;
  const FrameSetup& setup;
  std::optional<PictureRows> rows;  // the strip that is drawn; unset: the whole picture

  bool shows(const Box3& cells) const { return !rows || overlap(*rows, rowsOf(setup, cells)); }
};

// A channel while the frame is drawn.
class ChannelRun {
 public:
  // `frame` must outlive it.
  ChannelRun(const Session::Part& part, const SharedFrame& frame, uint32_t channel)
      : part_(part), frame_(frame), channel_(channel) {
    const TexturePlan& textures = part.plan->textures;
    for (const Cluster& cluster : textures.clusters) clusters_.insert(placeOf(cluster));
    for (const BlockPosition i : textures.blocks.indices())
      blocks_.emplace(ofAnyTime(textures.blocks[i].name), i);
    std::vector<ClusterPosition> order;
    order.reserve(frame.order.visits.size());
    for (const Visit& each : frame.order.visits) order.push_back(each.cluster);
    // The channel reads its own clusters, in the order in which the frame visits the union's.
    DrawOrder own{frame.order.eye, {}};
    for (const ClusterPosition cluster : ownClusters(textures, frame.all, order))
      own.visits.push_back({.cluster = cluster, .draws = true, .blocks = {}});
    const ReadPurpose purpose{tally_, part.options.stop};
    ReadAhead::Needs needs;
    // The chunks of other strips are not read.
    if (frame.rows) needs.now = [this](ChunkPosition chunk) { return shows(chunk); };
    ahead_ = std::make_unique<ReadAhead>(residency(), part.plan, own, purpose, needs);
    // A frame that was stopped may have left chunks pinned.
    residency().unpinAll();
  }
  ~ChannelRun() {
    // Reading ends before the device and the buffers are used for something else.
    ahead_.reset();
    residency().chunks().waitUntilIdle();
  }
  ChannelRun(const ChannelRun&) = delete;
  ChannelRun& operator=(const ChannelRun&) = delete;

  // Makes the chunks of a cluster of all channels resident.
  void load(const Cluster& cluster, const ReadAhead::Deadline& deadline) {
    // A cluster of the union in which this channel shows nothing.
    if (!clusters_.contains(placeOf(cluster))) return;
    while (const auto taken = ahead_->take(deadline)) {
      part_.options.stop.throwIfStopped();
      const auto request = [&](ChunkPosition chunk, ChunkName name) {
        if (part_.trace != nullptr)
          part_.trace->write(
              requestFor(part_.plan->textures, chunk, name, taken->step.cluster, part_.number));
      };
      loadChunks(*taken, *part_.plan, *ahead_, residency(), deadline.has_value(), report_, request);
      if (taken->step.completes_cluster) return;
    }
  }
  // Appends the channel's box of a block, if it has one and its chunk is there.
  void append(const BlockName& name, std::vector<BoxDraw>& boxes, bool joins) {
    const auto found = blocks_.find(ofAnyTime(name));
    if (found == blocks_.end()) return;
    const TexturePlan& textures = part_.plan->textures;
    const TextureBlock& block = textures.blocks[found->second];
    if (block.cells.empty()) return;  // loaded whole, shows nothing (algorithm II)
    if (!frame_.shows(block.cells)) return;
    const ChunkName chunk = part_.plan->names[block.chunk];
    if (!residency().isResident(chunk)) {
      missing_cells_ += static_cast<double>(block.cells.count());  // left out at the time limit
      return;
    }
    BoxDraw box = boxDraw(textures, block);
    box.chunk = residency().idOf(chunk);
    box.channel = channel_;
    box.joins = joins;
    boxes.push_back(box);
    ++report_.boxes_drawn;
  }
  void unpinAll() { residency().unpinAll(); }
  FrameReport report() {
    addCounts(*part_.visible, *part_.plan, *tally_, report_);
    if (missing_cells_ > 0)
      report_.missing_share = missing_cells_ / static_cast<double>(part_.plan->cells);
    report_.step_vox = part_.options.step_vox;
    return report_;
  }

 private:
  Residency& residency() const { return part_.session->residency(); }
  bool shows(ChunkPosition chunk) const {
    const TexturePlan& textures = part_.plan->textures;
    return std::ranges::any_of(textures.chunks[chunk].blocks, [&](BlockPosition block) {
      return frame_.shows(textures.blocks[block].cells);
    });
  }

  const Session::Part& part_;
  const SharedFrame& frame_;
  const uint32_t channel_;
  const std::shared_ptr<ReadTally> tally_ = std::make_shared<ReadTally>();
  std::set<ClusterPlace> clusters_;
  std::unordered_map<BlockName, BlockPosition, BlockNameHash> blocks_;  // of any time
  std::unique_ptr<ReadAhead> ahead_;
  FrameReport report_;
  double missing_cells_ = 0;
};

FrameSetup setupOf(const std::vector<Session::Part>& parts, const View& view) {
  // The view and the volume are those of the first channel: all have one grid and one world.
  std::vector<FrameSetup> setups;
  setups.reserve(parts.size());
  for (const Session::Part& part : parts)
    setups.push_back(frameSetup(view, parts.front().step.source->layout(), *part.look,
                                part.step.ranges->map, part.options, part.lit));
  FrameSetup first = std::move(setups.front());
  setups.erase(setups.begin());
  first.others = std::move(setups);
  return first;
}

// Ends a frame that throws.
class DeviceFrame {
 public:
  explicit DeviceFrame(Device& device) : device_(device) {}
  ~DeviceFrame() { device_.cancelFrame(); }
  DeviceFrame(const DeviceFrame&) = delete;
  DeviceFrame& operator=(const DeviceFrame&) = delete;

 private:
  Device& device_;
};

}  // namespace

Frame blendedFrame(const Session::Parts& made, Device& device, std::vector<FrameReport>& reports) {
  const auto asked_at = std::chrono::steady_clock::now();
  const Stopwatch watch;
  Stopwatch stage;
  const std::vector<Session::Part>& parts = made.of_sessions;
  const Session::Part& first = parts.front();
  const FrameOptions& options = first.options;
  const VolumeLayout& volume = first.step.source->layout();
  const View view = resolve(options, volume);
  const TexturePlan& all = *made.all;
  const DrawOrder order = makeDrawOrder(all, eyePosition(view, volume), Arrangement::kRows);
  const FrameSetup setup = setupOf(parts, view);
  const double plan_s = made.plan_s + stage.lap();

  ReadAhead::Deadline deadline;
  // Drawing is expected to take as long as the last time: reading ends so much earlier.
  if (options.time_limit_s)
    deadline = asked_at +
               std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(
                   *options.time_limit_s - first.last_draw_s - made.classify_s - made.plan_s));
  const DeviceFrame ends(device);
  device.beginFrame(setup, options.stop);
  const SharedFrame shared{all, order, setup, rowsOf(device)};
  std::vector<std::unique_ptr<ChannelRun>> channels;
  channels.reserve(parts.size());
  for (const Session::Part& part : parts)
    channels.push_back(
        std::make_unique<ChannelRun>(part, shared, static_cast<uint32_t>(channels.size())));
  std::vector<BoxDraw> boxes, counted;
  double draw_s = 0;
  for (size_t i = 0; i < order.visits.size(); ++i) {
    if (options.watch) options.watch(i, order.visits.size());
    options.stop.throwIfStopped();
    const Visit& visit = order.visits[i];
    for (const auto& channel : channels) channel->load(all.clusters[visit.cluster], deadline);
    stage.lap();
    for (const BlockPosition position : visit.blocks) {
      const TextureBlock& block = all.blocks[position];
      // The boxes of one block follow each other and join: the device samples them together, as one
      // medium.
      const size_t before = boxes.size();
      for (const auto& channel : channels)
        channel->append(block.name, boxes, boxes.size() > before);
    }
    if (!boxes.empty()) device.draw(boxes);
    if (options.count_samples) counted.insert(counted.end(), boxes.begin(), boxes.end());
    boxes.clear();
    // Only now: the device has drawn what it borrowed or copied of these chunks.
    for (const auto& channel : channels) channel->unpinAll();
    draw_s += stage.lap();
  }
  if (options.watch) options.watch(order.visits.size(), order.visits.size());
  Frame frame;
  frame.picture = device.endFrame();
  draw_s += stage.lap();
  reports.clear();
  for (const auto& channel : channels) reports.push_back(channel->report());
  uint64_t read_bytes = 0;
  for (const FrameReport& report : reports) read_bytes += report.decoded_bytes;
  const double reading_s = watch.seconds() - draw_s;
  for (size_t i = 0; i < parts.size(); ++i)
    parts[i].session->noteDrawn(parts[i], draw_s, reading_s, read_bytes, reports[i]);
  // The times of the whole frame go to the first channel's report alone: the sum over the channels
  // counts them once.
  FrameReport& work = reports.front();
  work.stages.classify = made.classify_s;
  work.stages.plan = plan_s;
  work.stages.draw = draw_s;
  if (options.count_samples) {
    const uint64_t taken = setup.counts_taken ? device.takenSamples() : 0;
    work.samples_drawn = device.countSamples(counted);
    work.samples_taken = setup.counts_taken ? taken : work.samples_drawn;
  }
  work.seconds = made.classify_s + made.plan_s + watch.seconds();
  frame.report = reports.front();
  for (size_t i = 1; i < reports.size(); ++i) addLayer(frame.report, reports[i]);
  frame.report.seconds = work.seconds;
  frame.blocks = first.visible;
  return frame;
}

}  // namespace sluice
