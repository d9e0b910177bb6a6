#include "tools/scene/turn.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "src/render/camera/frame_setup.h"
#include "src/render/session/planner.h"
#include "src/render/session/union_plan.h"
#include "src/texture/frame_trace.h"
#include "src/volume/block_side.h"
#include "tools/command_line/console.h"
#include "tools/options/shared_options.h"
#include "tools/scene/opened_picture.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

// Without the index of the finest level if no picture of the turn shows that level.
OpenedPicture openTurned(const TurnArguments& arguments, WorkerPool& pool, const Outputs& outputs) {
  const auto open = [&](FinestLevel finest) {
    return openPicture({arguments.volume, arguments.look, arguments.frame, arguments.resources,
                        arguments.fit, turnOf(arguments.frame.camera, arguments.frames)},
                       finest, outputs, pool);
  };
  OpenedPicture turned = open(FinestLevel::kMayWait);
  if (mustReadFinest(turned, arguments.frame, pool)) return open(FinestLevel::kRead);
  if (!arguments.resources.quiet)
    for (const std::string& note : standInNotes(turned)) printWarning(note);
  return turned;
}

// The channels of a picture and the turn around it.
class TurnedChannels {
 public:
  TurnedChannels(const TurnArguments& arguments, const Outputs& outputs)
      : arguments_(arguments),
        pool_(arguments.resources.threads),
        picture_(openTurned(arguments, pool_, outputs)),
        looks_(picture_.looks()),
        combine_(combineOf(arguments.look, frameAt(0), looks_)),
        blends_(sluice::blends(combine_, looks_.size())),
        shares_(channelShares(looks_, combine_, frameAt(0), arguments.resources, 0, pool_)) {
    for (const ChannelShare& share : shares_) {
      transfers_.push_back(std::make_shared<const TransferFunction>(*share.look.transfer));
      choosers_.push_back(std::make_unique<Planner>(share.page, pool_, names_));
    }
  }

  size_t count() const { return shares_.size(); }
  const IndexedVolume& volume(size_t channel) const { return picture_.volumes[channel]; }
  // A line for each option that was given for nothing.
  std::vector<std::string> idle() const {
    return optionWarnings(arguments_.given, arguments_.look, frameAt(0), {}, arguments_.resources,
                          picture_);
  }
  // The lines that opening the volumes has printed.
  std::vector<std::string> openingNotes() const {
    std::vector<std::string> notes = standInNotes(picture_);
    std::ranges::copy(notesOf(picture_), std::back_inserter(notes));
    return notes;
  }

  // All sizes below are in pages that the user asks for. Caches of blended channels have room for
  // as many blocks each, so that some get fewer.
  uint64_t defaultPages(size_t channel) const {
    int64_t pages = shares_[channel].page.pages;
    for (const ChannelShare& share : shares_)
      if (blends_) pages = std::max(pages, share.page.pages);
    return static_cast<uint64_t>(pages);
  }
  uint64_t leastPages(size_t channel) const {
    int64_t pages = 0;
    for (size_t i = 0; i < count(); ++i) {
      if (!blends_ && i != channel) continue;
      const IndexedVolume& of = volume(i);
      const int64_t side = blockSide(of.layout, of.source->layout().levels);
      pages = std::max(pages, of.numbers() * of.page.pagesOf({side, side, side}));
    }
    return static_cast<uint64_t>(pages);
  }
  // The pages of the channel's cache.
  uint64_t cachePages(size_t channel, uint64_t asked) const {
    return static_cast<uint64_t>(pagesFor(asked)[channel].pages);
  }
  // The size that the chunks for such a cache are planned for.
  uint64_t plannedFor(size_t channel, uint64_t asked) const {
    if (!arguments_.is_plan_fixed) return asked;
    return arguments_.fixed_pages != 0 ? arguments_.fixed_pages : defaultPages(channel);
  }

  Trace records(size_t channel, uint64_t asked) {
    const std::vector<PageGeometry> pages = pagesFor(plannedFor(channel, asked));
    ChunkNames names;
    Planner planner(pages[channel], pool_, names);
    Trace trace;
    trace.page_bytes = static_cast<uint64_t>(pages[channel].pageBytes());
    Together together;
    for (int64_t frame = 0; frame < arguments_.frames; ++frame) {
      const auto requests = blends_ ? blendedRequests(channel, frame, pages, planner, together)
                                    : ownRequests(channel, frame, planner);
      trace.records.insert(trace.records.end(), requests.begin(), requests.end());
    }
    return trace;
  }

 private:
  // The blocks that all channels show together, which frames keep while they stay the same.
  struct Together {
    std::vector<VisibleBlocksPtr> visible;
    TexturePlanPtr all;
  };

  FrameOptions frameAt(int64_t frame) const {
    FrameOptions options = arguments_.frame;
    options.camera = picture_.cameras[static_cast<size_t>(frame)];
    return options;
  }
  FrameOptions optionsOf(size_t channel, int64_t frame) const {
    return frameOfChannel(looks_[channel], looks_, combine_, frameAt(frame));
  }
  View viewOf(size_t channel, const FrameOptions& options) const {
    return resolve(options, volume(channel).source->layout());
  }
  EyePosition eyeOf(size_t channel, const FrameOptions& options) const {
    return eyePosition(viewOf(channel, options), volume(channel).source->layout());
  }

  // The geometry of each channel's cache if so many pages are asked for.
  std::vector<PageGeometry> pagesFor(uint64_t asked) const {
    std::vector<PageGeometry> pages;
    pages.reserve(count());
    std::vector<std::pair<const IndexedVolume*, PageGeometry*>> to_even;
    for (const ChannelShare& share : shares_) {
      pages.push_back(share.page);
      pages.back().pages = static_cast<int64_t>(asked);
      to_even.emplace_back(share.look.volume, &pages.back());
    }
    if (blends_) evenOutPages(to_even);
    return pages;
  }

  // Those of the channel's own frame.
  std::vector<TraceRecord> ownRequests(size_t channel, int64_t frame, Planner& planner) const {
    const FrameOptions options = optionsOf(channel, frame);
    const FramePlanPtr plan = planner.planFor(shares_[channel].step, transfers_[channel], options);
    return frameRequests(plan->textures, plan->names, eyeOf(channel, options), frame);
  }

  // Those of the channel in a frame that blends all, see Session::parts() and blendedFrame().
  std::vector<TraceRecord> blendedRequests(size_t channel, int64_t frame,
                                           const std::vector<PageGeometry>& pages, Planner& planner,
                                           Together& together) const {
    const std::vector<VisibleBlocksPtr> visible = visibleTogether(frame);
    const auto has_blocks = [](const VisibleBlocksPtr& blocks) { return !blocks->blocks.empty(); };
    // A medium of one channel is that channel's own frame.
    if (std::ranges::count_if(visible, has_blocks) == 1)
      return has_blocks(visible[channel]) ? ownRequests(channel, frame, planner)
                                          : std::vector<TraceRecord>();
    FrameOptions first = optionsOf(0, frame), own = optionsOf(channel, frame);
    first.algorithm = own.algorithm = blendedAlgorithm(first.algorithm, visible);
    if (visible != together.visible) {
      std::vector<ChannelBlocks> blocks;
      blocks.reserve(count());
      for (size_t i = 0; i < count(); ++i)
        blocks.push_back({shares_[i].step.layout(), visible[i], pages[i]});
      const TimeStep& step = shares_.front().step;
      together.all = std::make_shared<const TexturePlan>(
          unionPlan(blocks, {first.algorithm, first.merge_order, step.time,
                             cropCells(first, step.ranges->layout.dims)}));
      together.visible = visible;
    }
    const FramePlanPtr plan =
        planner.plan(shares_[channel].step, visible[channel], own, together.all);
    const std::vector<ClusterPosition> order =
        ownClusters(plan->textures, *together.all, clusterOrder(*together.all, eyeOf(0, first)));
    return frameRequests(plan->textures, plan->names, order, frame);
  }

  std::vector<VisibleBlocksPtr> visibleTogether(int64_t frame) const {
    std::vector<Planner*> asked;
    std::vector<BlockQuestion> questions;
    for (size_t i = 0; i < count(); ++i) {
      const FrameOptions options = optionsOf(i, frame);
      asked.push_back(choosers_[i].get());
      const LookPtr look = asked.back()->look(shares_[i].step, transfers_[i], options.mode);
      questions.push_back(Planner::question(shares_[i].step, look, viewOf(i, options), options));
    }
    return Planner::visibleTogether(asked, questions);
  }

  const TurnArguments arguments_;
  Workers pool_;
  const OpenedPicture picture_;
  const std::vector<LayerLook> looks_;
  const Combine combine_;
  const bool blends_;
  const std::vector<ChannelShare> shares_;
  std::vector<TransferPtr> transfers_;
  ChunkNames names_;                                // no chunk gets one
  std::vector<std::unique_ptr<Planner>> choosers_;  // of blocks alone
};

class Turn final : public ReplaySource {
 public:
  Turn(std::shared_ptr<TurnedChannels> channels, size_t channel)
      : channels_(std::move(channels)), channel_(channel), volume_(channels_->volume(channel)) {}

  std::string title() const override {
    const std::string& name = volume_.source->layout().name;
    return channel() == nullptr ? name : fmt::format("{}, {}", name, volume_.channel.title());
  }
  const ShownChannel* channel() const override {
    return channels_->count() > 1 ? &volume_.channel : nullptr;
  }
  std::vector<std::string> files() const override { return volume_.source->files(); }
  std::vector<std::string> warnings() const override {
    return channel_ == 0 ? channels_->idle() : std::vector<std::string>();
  }
  std::vector<std::string> openingNotes() const override {
    return channel_ == 0 ? channels_->openingNotes() : std::vector<std::string>();
  }
  uint64_t defaultPages() const override { return channels_->defaultPages(channel_); }
  uint64_t leastPages() const override { return channels_->leastPages(channel_); }
  uint64_t cachePages(uint64_t asked) const override {
    return channels_->cachePages(channel_, asked);
  }
  std::optional<uint64_t> plannedPages(uint64_t asked) const override {
    return cachePages(channels_->plannedFor(channel_, asked));
  }

  PreparedTrace requests(uint64_t asked) override { return prepare(records(asked)); }
  uint64_t visit(uint64_t asked, const std::function<void(const TraceRecord&)>& take) override {
    const Trace trace = records(asked);
    for (const TraceRecord& record : trace.records) take(record);
    return trace.page_bytes;
  }
  Trace records(uint64_t asked) override { return channels_->records(channel_, asked); }

 private:
  const std::shared_ptr<TurnedChannels> channels_;
  const size_t channel_;
  const IndexedVolume& volume_;
};

}  // namespace

std::vector<std::unique_ptr<ReplaySource>> openTurn(const TurnArguments& arguments,
                                                    const Outputs& outputs) {
  TurnArguments turn = arguments;
  turn.look.whole_series = looksAtAllSteps(turn.look, turn.frame, turn.fit);
  turn.frame.cut = cutOptions(turn.resources, turn.look, turn.frame,
                              turn.frames == 1 ? PictureRow::kOne : PictureRow::kMore);
  const auto channels = std::make_shared<TurnedChannels>(turn, outputs);
  std::vector<std::unique_ptr<ReplaySource>> sources;
  sources.reserve(channels->count());
  for (size_t i = 0; i < channels->count(); ++i)
    sources.push_back(std::make_unique<Turn>(channels, i));
  return sources;
}

}  // namespace sluice
