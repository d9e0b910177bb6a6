#include "tools/scene/scene.h"

#include <memory>
#include <utility>

#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"

namespace sluice {
namespace {

ProgressWatch indexingLine(const ResourceArguments& resources) {
  return resources.quiet ? ProgressWatch() : progressLine("indexing");
}

}  // namespace

IndexedVolume openIndexed(const VolumeArguments& arguments, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool, const Outputs& outputs) {
  outputs.checkNames();
  auto source = openSource(arguments);
  outputs.check(source->files());
  ProgressMeter progress(indexingLine(resources));
  IndexedVolume volume =
      indexVolume(std::move(source), arguments, resources, needs, indexWish(resources.index_dir),
                  {pool, progress, memoryBudget(resources), interruption(),
                   resources.quiet ? nullptr : printNotice});
  if (!resources.quiet)
    for (const std::string& note : volume.notes) printWarning(note);
  return volume;
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

bool mustReadFinest(const IndexedVolume& volume, const TransferFunction& transfer,
                    const FrameOptions& frame, std::span<const Camera> cameras, WorkerPool& pool) {
  if (!volume.stand_in || frame.time_limit_s || frame.cut->most_stored_bytes != UINT64_MAX)
    return false;
  return showsFinest(volume.step(), transfer, frame, cameras, pool);
}

void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const ResourceArguments& resources, WorkerPool& pool) {
  ProgressMeter progress(indexingLine(resources));
  fitCameras(cameras, choice, request, room,
             {pool, progress, memoryBudget(resources), interruption()});
}

TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look) {
  return lookFor(volume, look, Mode::kComposite).transfer;
}

Scene openScene(const VolumeArguments& volume, const LookArguments& look,
                const ResourceArguments& resources, const FrameOptions& frame,
                const Outputs& outputs, Team* team, FinestLevel finest) {
  auto pool = std::make_shared<Workers>(resources.threads);
  auto indexed = std::make_shared<const IndexedVolume>(
      openIndexed(volume, resources, pictureNeeds(look, frame, finest), *pool, outputs));
  return {
      {.pool = std::move(pool), .volume = std::move(indexed), .machine = resources, .team = team},
      look,
      frame};
}

}  // namespace sluice
