#include "tools/scene.h"

#include <algorithm>
#include <utility>

#include "src/base/clock.h"
#include "tools/command_line/console.h"
#include "tools/command_line/progress_line.h"
#include "tools/environment.h"
#include "tools/interrupt.h"

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
  outputs.check(filesOf(*source));
  ProgressMeter progress(indexingLine(resources));
  IndexedVolume volume =
      indexVolume(std::move(source), arguments, resources, needs, indexWish(resources.index_dir),
                  {pool, progress, memoryBudget(resources), interruption()});
  if (!resources.quiet)
    for (const std::string& note : volume.notes) printWarning(note);
  return volume;
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
    : pool(resources.threads),
      volume(openIndexed(arguments, resources, needsOf(arguments_look, mode), pool, outputs)),
      memory_bytes(memoryBudget(resources)),
      device(makeDevice(resources.device, pool)),
      look(lookFor(volume, arguments_look, mode)),
      transfer(look.transfer) {
  session = std::make_unique<Session>(
      volume.step(), *device, pool,
      sessionOptions(volume, look.lit, resources, partition, memory_bytes));
  session->setTransferFunction(transfer);
  noteMemory();
}

void Scene::noteMemory() {
  peak_anonymous_bytes = std::max(peak_anonymous_bytes, anonymousBytes());
}

}  // namespace sluice
