#include "src/library/drawing/scene/channel_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "src/library/drawing/cost/picture_memory.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/blocks/losses/lost_surfaces.h"
#include "src/render/light/arriving_light.h"
#include "src/render/session/budgets.h"
#include "src/volume/block_side.h"

namespace sluice {
namespace {

int64_t pagesOfBlock(const IndexedVolume& volume, const PageGeometry& page) {
  const int levels = volume.pyramid != nullptr ? volume.pyramid->levels() : 1;
  const int64_t side = blockSide(volume.layout, levels);
  return page.pagesOf(Vec3i{side, side, side});
}

// Whether the coarser levels hold labels, which other looks of them have no use for.
bool holdsLabels(const IndexedVolume& volume) {
  return std::ranges::any_of(volume.step().coarser, [](const CoarserStep& level) {
    return level.valuesShown() == LevelValues::kModes;
  });
}

// A level that is asked for is that of the first volume alone.
std::optional<CutOptions> cutOfLayer(const IndexedVolume& volume, const TransferFunction& transfer,
                                     std::optional<CutOptions> cut) {
  if (!cut || !volume.channel.is_over) return cut;
  cut->level.reset();
  if (transfer.labels || holdsLabels(volume)) cut->is_default = true;
  return cut;
}

}  // namespace

FrameOptions frameOfLayer(const IndexedVolume& volume, const TransferFunction& transfer,
                          const VolumeLayout& first, const FrameOptions& frame) {
  FrameOptions own = frameOn(volume.source->layout(), first, frame);
  own.cut = cutOfLayer(volume, transfer, frame.cut);
  return own;
}

FrameOptions frameOfChannel(const LayerLook& channel, const std::vector<LayerLook>& channels,
                            Combine combine, const FrameOptions& frame) {
  if (channels.size() == 1) return frame;
  // A session that is opened before its pictures have a size has no view yet.
  const bool has_view = frame.size.width > 0 && frame.size.height > 0;
  FrameOptions own = has_view ? frameOfLayer(*channel.volume, *channel.transfer,
                                             channels.front().volume->source->layout(), frame)
                              : frame;
  if (own.cut) own.cut = shareOf(*own.cut, channels.size());
  if (!blends(combine, channels.size())) return own;
  // Blended channels are sampled at the same places, so they show coarse levels only if all of them
  // can.
  if (!haveOneCut(frame, channels)) own.cut.reset();
  if (own.cut) own.cut->level = frame.cut->level;
  // The integral between two samples is one channel's, and a blended sample has several.
  own.integrates = false;
  return own;
}

namespace {

// Two volumes in a message. Channels of one file are told apart by their numbers.
std::pair<std::string, std::string> twoNames(const VolumeLayout& a, const VolumeLayout& b) {
  if (a.calledBy() != b.calledBy()) return {a.calledBy(), b.calledBy()};
  return {fmt::format("channel {} of {}", a.channel, a.calledBy()),
          fmt::format("channel {}", b.channel)};
}

}  // namespace

std::optional<BlendObstacle> blendObstacle(const LookArguments& look, const FrameOptions& options,
                                           const std::vector<const VolumeLayout*>& grids) {
  // A blended sample reads all channels at one place of one block.
  for (const VolumeLayout* grid : grids)
    if (!isSameGrid(*grid, *grids.front())) {
      const auto [other, first] = twoNames(*grid, *grids.front());
      return BlendObstacle{
          fmt::format("--combine blend: {} is on another grid of voxels than {}; leave out "
                      "--combine, which adds their pictures",
                      other, first)};
    }
  if (!traitsOf(options.mode).has_colors)
    return BlendObstacle{
        "--combine blend needs --mode composite, since other modes show one value a pixel; leave "
        "out --combine, which adds the pictures of the channels"};
  if (!look.surfaces.empty())
    return BlendObstacle{"--combine blend draws no surfaces; leave out --iso", true};
  if (options.lighting.looksAround())
    return BlendObstacle{
        "--combine blend knows no light that looks around; leave out --shadows and "
        "--occlusion-light",
        true};
  if (options.occlusion != Occlusion::kOff || options.partition != Partition::kBlocks)
    return BlendObstacle{
        "--combine blend draws whole blocks; leave out --occlusion and --partition", true};
  return std::nullopt;
}

namespace {

std::optional<BlendObstacle> blendObstacle(const LookArguments& look, const FrameOptions& options,
                                           const std::vector<LayerLook>& layers) {
  std::vector<const VolumeLayout*> grids;
  grids.reserve(layers.size());
  for (const LayerLook& layer : layers) grids.push_back(&layer.volume->source->layout());
  if (auto obstacle = blendObstacle(look, options, grids)) return obstacle;
  const IndexedVolume& first = *layers.front().volume;
  for (const LayerLook& layer : layers)
    if (!haveOneLayout(*layer.volume, first)) {
      const auto [other, one] = twoNames(layer.volume->source->layout(), first.source->layout());
      return BlendObstacle{
          fmt::format("--combine blend: {} is read in other blocks than {}; give both the same "
                      "--block, and levels of resolution to both or none",
                      other, one)};
    }
  return std::nullopt;
}

// Whether all layers have the level that is asked for, of what each shows.
bool haveLevelAsked(const FrameOptions& options, const std::vector<LayerLook>& layers) {
  const int asked = options.cut ? options.cut->level.value_or(0) : 0;
  const PyramidLayout levels = layers.front().volume->step().layout();
  return asked == 0 || std::ranges::all_of(layers, [&](const LayerLook& layer) {
           const TimeStep step = layer.volume->step();
           return asked < levelsInCommon(levels, step.layout()) &&
                  std::ranges::all_of(step.coarser, [&](const CoarserStep& level) {
                    return (level.valuesShown() == LevelValues::kModes) == layer.transfer->labels;
                  });
         });
}

}  // namespace

void requireBlendable(const LookArguments& look, const FrameOptions& options,
                      const std::vector<LayerLook>& layers) {
  if (look.combine != Combine::kBlend || layers.size() < 2) return;
  if (const auto obstacle = blendObstacle(look, options, layers)) failRequest("{}", obstacle->line);
}

Combine combineOf(const LookArguments& look, const FrameOptions& options,
                  const std::vector<LayerLook>& layers) {
  if (look.combine) return *look.combine;
  const bool are_two = layers.size() == 2 && layers.back().volume->channel.is_over;
  return are_two && !blendObstacle(look, options, layers) && haveLevelAsked(options, layers)
             ? Combine::kBlend
             : Combine::kAdd;
}

std::string addedNote(const LookArguments& look, const FrameOptions& options,
                      const std::vector<LayerLook>& layers) {
  const bool are_two = layers.size() == 2 && layers.back().volume->channel.is_over;
  if (look.combine || !are_two || !traitsOf(options.mode).has_colors) return "";
  // Obstacles that no option removes come first, but for blocks, which may differ because the
  // volumes are added.
  const auto obstacle = blendObstacle(look, options, layers);
  if (!obstacle || !obstacle->is_option) return "";
  return fmt::format(
      "the pictures of the two volumes are added, not blended: {}, or give --combine add",
      obstacle->line);
}

bool integratesSamples(const FrameOptions& options, const LayerLook& layer) {
  return options.integrates && traitsOf(options.mode).has_colors && !layer.transfer->labels &&
         layer.transfer->surfaces.empty() &&
         !drawsCut(layer.volume->step(), options.cut, options.mode, *layer.transfer) &&
         hasIntegratedSteps(options, *layer.volume);
}

bool hasIntegratedSteps(const FrameOptions& options, const IndexedVolume& volume) {
  const VolumeLayout& layout = volume.source->layout();
  return stepsIntegrate(resolve(options, layout), layout);
}

bool haveOneLayout(const IndexedVolume& a, const IndexedVolume& b) {
  return a.layout.size == b.layout.size && a.layout.ghost == b.layout.ghost;
}

bool haveOneCut(const FrameOptions& options, const std::vector<LayerLook>& layers) {
  const IndexedVolume& first = *layers.front().volume;
  const PyramidLayout levels = first.step().layout();
  const int asked = options.cut ? options.cut->level.value_or(0) : 0;
  bool draw_cuts = true;
  int in_common = levels.levels();
  for (const LayerLook& layer : layers) {
    const IndexedVolume& volume = *layer.volume;
    std::optional<CutOptions> cut = cutOfLayer(volume, *layer.transfer, options.cut);
    if (asked > 0) cut->is_default = false;  // the level is that of all
    draw_cuts &= drawsCut(volume.step(), cut, options.mode, *layer.transfer);
    in_common = std::min(in_common, levelsInCommon(levels, volume.step().layout()));
    if (asked >= in_common) {
      const auto [other, one] = twoNames(volume.source->layout(), first.source->layout());
      failRequest(
          "--level {}: {} has no such level in common with {}; leave out --level, or --combine "
          "blend, which draws all channels at one level",
          asked, other, one);
    }
  }
  return draw_cuts && in_common > 1;
}

void evenOutPages(const std::vector<std::pair<const IndexedVolume*, PageGeometry*>>& pages) {
  int64_t blocks = std::numeric_limits<int64_t>::max();
  for (const auto& [volume, page] : pages)
    // A chunk that only some channels have room for could not be drawn.
    blocks = std::min(blocks, page->pages / pagesOfBlock(*volume, *page));
  for (const auto& [volume, page] : pages)
    page->pages = std::max<int64_t>(1, blocks) * pagesOfBlock(*volume, *page);
}

uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool) {
  // A series also holds the ranges of the step that is shown and of the next one.
  const uint64_t steps = volume.source->layout().time_steps > 1 ? 3 : 1;
  const uint64_t light_bytes =
      frame.lighting.looksAround() ? lightBytes(volume.source->layout(), pool.threads()) : 0;
  const bool judges_surfaces = !transfer.surfaces.empty() && volume.pyramid != nullptr;
  const uint64_t judging_bytes =
      judges_surfaces ? static_cast<uint64_t>(pool.threads()) * judgingBytes(volume.layout.size)
                      : 0;
  return steps * volume.rangesBytes() + planBytes(volume, transfer, frame, pool) + light_bytes +
         judging_bytes;
}

void failOfShare(const Error& error, size_t channels, std::optional<uint64_t> least_bytes) {
  // Told of all channels together, since the user gives the memory of all.
  if (const auto* const shortage = dynamic_cast<const MemoryShortage*>(&error))
    throw MemoryShortage(shortage->ofOne(), channels, least_bytes);
  if (channels == 1 || error.kind() != Error::Kind::kMemory) throw Error(error);
  failAs(error.kind(), "{} ({} channels share the memory evenly, and this is the part of one)",
         error.what(), channels);
}

MachineOptions shareOf(MachineOptions machine, size_t channels) {
  if (channels > 1) machine.memory_bytes = memoryBudget(machine) / channels;
  return machine;
}

std::vector<ChannelShare> channelShares(const std::vector<LayerLook>& channels, Combine combine,
                                        const FrameOptions& frame, const MachineOptions& machine,
                                        uint64_t more_bytes, WorkerPool& pool) {
  std::vector<ChannelShare> shares;
  shares.reserve(channels.size());
  for (const LayerLook& channel : channels) {
    const IndexedVolume& volume = *channel.volume;
    ChannelShare& share =
        shares.emplace_back(ChannelShare{.look = channel,
                                         .step = volume.step(),
                                         .frame = frameOfChannel(channel, channels, combine, frame),
                                         .machine = shareOf(machine, channels.size()),
                                         .page = volume.page});
    share.others_bytes = othersBytes(volume, *channel.transfer, share.frame, pool) + more_bytes;
    share.page.pages = besideShare(volume, share.machine, share.frame.partition,
                                   pictureDemand(share.machine, share.frame), share.others_bytes)
                           .pages;
  }
  if (!blends(combine, channels.size())) return shares;
  std::vector<std::pair<const IndexedVolume*, PageGeometry*>> pages;
  pages.reserve(shares.size());
  for (ChannelShare& share : shares) pages.emplace_back(share.look.volume, &share.page);
  evenOutPages(pages);
  return shares;
}

}  // namespace sluice
