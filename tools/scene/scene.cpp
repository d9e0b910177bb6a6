#include "tools/scene/scene.h"

#include <algorithm>
#include <utility>

#include "src/base/threads/clock.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/scene/scene_session.h"

namespace sluice {
namespace {

ProgressWatch indexingLine(const ResourceArguments& resources) {
  return resources.quiet ? ProgressWatch() : progressLine("indexing");
}

FrameOptions withPartition(Partition partition, Mode mode) {
  FrameOptions frame;
  frame.partition = partition;
  frame.mode = mode;
  return frame;
}

}  // namespace

IndexedVolume openIndexed(const VolumeArguments& arguments, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool, const Outputs& outputs) {
  outputs.checkNames();
  auto source = openSource(arguments);
  outputs.check(filesOf(*source));
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

Scene::Scene(const VolumeArguments& arguments, const LookArguments& arguments_look,
             const ResourceArguments& resources, Partition partition, Mode mode,
             const Outputs& outputs)
    : Scene(arguments, arguments_look, resources, withPartition(partition, mode), outputs,
            nullptr) {}

Scene::Scene(const VolumeArguments& arguments, const LookArguments& arguments_look,
             const ResourceArguments& resources, const FrameOptions& frame, const Outputs& outputs,
             Team* team, FinestLevel finest)
    : pool(resources.threads),
      volume(openIndexed(arguments, resources, pictureNeeds(arguments_look, frame, finest), pool,
                         outputs)),
      memory_bytes(memoryBudget(resources)),
      pictures(pictureDemand(resources, frame)),
      device(makeDevice(resources.device, pool)),
      look(lookFor(volume, arguments_look, frame.mode)),
      transfer(look.transfer) {
  if (team != nullptr) {
    const int level = frame.cut ? frame.cut->level.value_or(0) : 0;
    const Dealing dealing = dealBlocks(volume.step().layout(), team->ranks(), level);
    part_bytes = partBytes(frame.size, dealing, memory_bytes);
    share = std::make_unique<RankShare>(*team, dealing, pool, part_bytes);
    device = share->deviceFrom(std::move(device));
  }
  openSession(*this, resources, frame, 0);
  noteMemory();
}

void Scene::chooseBlocksBy(BlockChooser* chooser) {
  if (session != nullptr) session->chooseBlocksBy(share ? share->chooserFrom(chooser) : chooser);
}

Frame Scene::frame() {
  Frame frame = session->frame();
  if (!share) return frame;
  frame.picture = share->picture();
  if (frame.report.cut) frame.report.cut->spread.reset();  // of this rank's blocks alone
  const CompositingReport& parts = share->report();
  frame.report.seconds += parts.exchange_seconds + parts.compose_seconds + parts.gather_seconds;
  return frame;
}

void Scene::keepLearntRanges() const {
  if (!volume.stand_in || session == nullptr) return;
  const std::shared_ptr<const SliceRanges> learnt = session->ranges();
  if (learnt->unknown.size() < volume.index->ranges.unknown.size())
    keepLearnt(*volume.source, volume.places, volume.time, *learnt);
}

void Scene::noteMemory() {
  peak_anonymous_bytes = std::max(peak_anonymous_bytes, anonymousBytes());
}

}  // namespace sluice
