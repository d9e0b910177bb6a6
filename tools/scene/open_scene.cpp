#include "tools/scene/open_scene.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "src/library/drawing/scene/resources.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/library/opening/channel_looks.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/light/arriving_light.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/command_line/usage.h"

namespace sluice {
namespace {

ProgressWatch indexingLine(const ResourceArguments& resources) {
  return resources.quiet ? ProgressWatch() : progressLine("indexing");
}

// Reads or builds the index of a channel; `machine` has the size of its blocks. `said`: notes that
// were printed; the channel's others are printed and added.
IndexedVolume indexed(ChannelSource opened, const ResourceArguments& resources,
                      const MachineOptions& machine, const IndexNeeds& needs,
                      const ExpectedPictures& pictures, WorkerPool& pool,
                      std::vector<std::string>& said) {
  ProgressMeter progress(indexingLine(resources));
  IndexPass pass = passOf(pool, progress, resources);
  if (!resources.quiet) pass.announce = printNotice;
  pass.together = opened.together;
  pass.pictures = pictures;
  IndexedVolume volume = indexVolume(std::move(opened.source), opened.arguments, machine, needs,
                                     indexWish(resources.index_dir), pass);
  volume.channel = std::move(opened.channel);
  std::ranges::move(opened.notes, std::back_inserter(volume.notes));
  if (!resources.quiet) printNewWarnings(volume.notes, said);
  return volume;
}

ExpectedPictures expectedPictures(const std::vector<ChannelSource>& channels,
                                  const LookArguments& look, const FrameOptions& frame,
                                  const ResourceArguments& resources, WorkerPool& pool) {
  ExpectedPictures pictures{.picture_bytes = leastPictureBytes(pictureDemand(resources, frame)),
                            .grows_boxes = frame.partition == Partition::kBoxes,
                            .is_compared = frame.strips == Strips::kNever,
                            .judges_surfaces = !look.surfaces.empty(),
                            .pages = resources.pages.value_or(0)};
  if (frame.lighting.looksAround())
    for (const ChannelSource& channel : channels)
      pictures.light_bytes =
          std::max(pictures.light_bytes, lightBytes(channel.source->layout(), pool.threads()));
  return pictures;
}

// Whether frames may blend the channels, as far as is known before their values are read, see
// combineOf().
bool mayBlend(const std::vector<ChannelSource>& channels, const LookArguments& look,
              const FrameOptions& frame) {
  if (look.combine) return *look.combine == Combine::kBlend;
  if (channels.size() != 2 || !channels.back().channel.is_over) return false;
  return !blendObstacle(look, frame,
                        {&channels.front().source->layout(), &channels.back().source->layout()});
}

}  // namespace

IndexPass passOf(WorkerPool& pool, ProgressMeter& progress, const ResourceArguments& resources) {
  return {{pool, progress, memoryBudget(resources), interruption()}};
}

IndexPass passOf(const Scene& scene, ProgressMeter& progress) {
  return {{scene.pool, progress, scene.memory_bytes, interruption()}};
}

IndexedVolume openIndexed(const VolumeArguments& arguments, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool, const Outputs& outputs) {
  outputs.checkNames();
  ChannelSource opened = openChannel(arguments);
  outputs.check(opened.source->files());
  std::vector<std::string> said;
  return indexed(std::move(opened), resources, resources, needs, {}, pool, said);
}

IndexedVolume openIndexed(const VolumeArguments& arguments, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool,
                          std::vector<std::string>& said) {
  return indexed(openChannel(arguments), resources, resources, needs, {}, pool, said);
}

std::vector<IndexedVolume> openIndexedChannels(const VolumeArguments& arguments,
                                               const LookArguments& look,
                                               const ResourceArguments& resources,
                                               const FrameOptions& frame, FinestLevel finest,
                                               WorkerPool& pool, const Outputs& outputs) {
  outputs.checkNames();
  std::vector<std::string> said;
  const auto openFor = [&](const FrameOptions& pictures) {
    std::vector<ChannelSource> opened = openChannels(arguments);
    for (const ChannelSource& channel : opened) outputs.check(channel.source->files());
    // Several channels have no row of pictures that begins with a sample.
    if (opened.size() > 1) finest = std::min(finest, FinestLevel::kMayWait);
    if (opened.size() > 1 && look.combine == Combine::kBlend)
      if (const auto obstacle = blendObstacle(look, pictures, {})) failUsage("{}", obstacle->line);
    const bool blends = opened.size() > 1 && mayBlend(opened, look, pictures);
    std::vector<IndexNeeds> needs;
    for (const ChannelSource& channel : opened) {
      FrameOptions own = pictures;
      // --level counts the levels of the first volume; the second one has its own.
      if (own.cut && channel.channel.is_over && look.combine != Combine::kBlend)
        own.cut->level.reset();
      LookArguments own_look = lookOfChannel(look, channel.channel);
      own_look.labels = own_look.labels || (own_look.map.empty() && own_look.opacities.empty() &&
                                            looksLikeLabels(channel));
      needs.push_back(pictureNeeds(own_look, own, finest));
    }
    // Blended channels are read in the same blocks.
    if (blends && std::ranges::any_of(needs, &IndexNeeds::gradients))
      for (IndexNeeds& each : needs) each.gradients = true;
    const VolumeLayout first = opened.front().source->layout();
    const ExpectedPictures expected = expectedPictures(opened, look, pictures, resources, pool);
    std::vector<IndexedVolume> volumes;
    for (size_t i = 0; i < opened.size(); ++i) {
      const MachineOptions machine =
          withBlocksOfFirst(resources, opened[i].source->layout(), first);
      volumes.push_back(
          indexed(std::move(opened[i]), resources, machine, needs[i], expected, pool, said));
    }
    return volumes;
  };
  std::vector<IndexedVolume> volumes = openFor(frame);
  const auto isAsFirst = [&](const IndexedVolume& volume) {
    return haveOneLayout(volume, volumes.front());
  };
  if (look.combine != Combine::kBlend || volumes.size() < 2 || !frame.cut ||
      std::ranges::all_of(volumes, isAsFirst))
    return volumes;
  // If only some have levels of resolution, the finest level of all is blended.
  for (const IndexedVolume& volume : volumes) requireLevel(*frame.cut, volume.step());
  FrameOptions finest_alone = frame;
  finest_alone.cut.reset();
  // The first opening ends before the second, so that both do not take memory at once.
  volumes.clear();
  return openFor(finest_alone);
}

std::vector<FittedVolume> fittedVolumes(const Scene& scene) {
  std::vector<FittedVolume> volumes;
  for (const Layer* layer : scene.layers())
    volumes.push_back({layer->volume, layer->volume.step(), layer->look.transfer});
  return volumes;
}

IndexNeeds pictureNeeds(const LookArguments& look, const FrameOptions& frame, FinestLevel finest) {
  IndexNeeds needs = needsOf(look, frame.mode, frame.cut);
  // Integrated frames take values beside a block's own.
  needs.gradients = needs.gradients || (frame.integrates && traitsOf(frame.mode).has_colors);
  // Growing boxes have an index of their own, which takes the finest level's.
  needs.may_stand_in = finest != FinestLevel::kRead && needs.levels != LevelNeeds::kFinest &&
                       frame.cut->level.value_or(1) > 0 && frame.partition == Partition::kBlocks &&
                       !frame.cut->keeps_thin;
  // The rest is for drawing, which takes longer on a busy machine.
  constexpr double kSampleShare = 1.0 / 3, kUnlimitedSeconds = 1;
  if (finest == FinestLevel::kMaySample)
    needs.sample_seconds = kSampleShare * frame.time_limit_s.value_or(kUnlimitedSeconds);
  return needs;
}

bool mustReadFinest(const Scene& scene, const FrameOptions& frame,
                    std::span<const Camera> cameras) {
  return std::ranges::any_of(scene.layers(), [&](const Layer* layer) {
    return mustReadFinest(layer->volume, layer->look.transfer, scene.volume.source->layout(), frame,
                          cameras, scene.pool);
  });
}

bool mustReadFinest(const IndexedVolume& volume, const TransferFunction& transfer,
                    const VolumeLayout& first, const FrameOptions& frame,
                    std::span<const Camera> cameras, WorkerPool& pool) {
  if (!volume.stand_in || frame.time_limit_s || frame.cut->most_stored_bytes != UINT64_MAX)
    return false;
  const VolumeLayout& layout = volume.source->layout();
  std::vector<Camera> own(cameras.begin(), cameras.end());
  if (!isSamePlace(layout, first))
    for (Camera& camera : own) camera = cameraOn(layout, first, camera, frame.size);
  return showsFinest(volume.step(), transfer, frameOfLayer(volume, transfer, first, frame), own,
                     pool);
}

void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const ResourceArguments& resources, WorkerPool& pool) {
  ProgressMeter progress(indexingLine(resources));
  fitCameras(cameras, choice, request, room, passOf(pool, progress, resources));
}

std::shared_ptr<const std::vector<Vec3d>> depthPoints(const FitRequest& request,
                                                      const ResourceArguments& resources,
                                                      WorkerPool& pool) {
  ProgressMeter progress(indexingLine(resources));
  return depthPoints(request, passOf(pool, progress, resources));
}

TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look) {
  return lookFor(volume, look, Mode::kComposite).transfer;
}

Scene openScene(const VolumeArguments& volume, const LookArguments& look,
                const ResourceArguments& resources, const FrameOptions& frame,
                const Outputs& outputs, Team* team, FinestLevel finest) {
  auto pool = std::make_shared<Workers>(resources.threads);
  std::vector<std::shared_ptr<const IndexedVolume>> channels;
  for (IndexedVolume& channel :
       openIndexedChannels(volume, look, resources, frame, finest, *pool, outputs))
    channels.push_back(std::make_shared<const IndexedVolume>(std::move(channel)));
  return {{.pool = std::move(pool),
           .volume = channels.front(),
           .more = {channels.begin() + 1, channels.end()},
           .machine = resources,
           .team = team},
          look,
          frame};
}

bool looksAtAllSteps(const LookArguments& look, const FrameOptions& frame, FitChoice fit) {
  return !look.this_step && (fitOf({frame.camera}, fit) == Fit::kVisible || colorsByDepth(frame));
}

}  // namespace sluice
