#include "tools/series.h"

#include <sstream>
#include <utility>

#include "src/base/error.h"
#include "src/classify/transfer/transfer_file.h"
#include "tools/command_line/console.h"
#include "tools/command_line/progress_line.h"
#include "tools/interrupt.h"
#include "tools/rank_agreement.h"
#include "tools/scene_session.h"

namespace sluice {
namespace {

ProgressWatch preparingLine(const ResourceArguments& resources) {
  return resources.quiet ? ProgressWatch() : progressLine("preparing");
}

}  // namespace

std::vector<std::string> basisFiles(const CullingArguments& culling) {
  std::vector<std::string> names;
  std::istringstream files(culling.basis);
  for (std::string file; std::getline(files, file, ',');) names.push_back(file);
  return names;
}

SeriesOptions seriesOptions(const CullingArguments& culling, const IndexedVolume& volume) {
  if (culling.part % kDetail != 0)
    fail("--part {}: a part has {} cubes a side; give a multiple of {}", culling.part, kDetail,
         kDetail);
  SeriesOptions options;
  options.difference = culling.difference;
  options.part_cells = culling.part;
  options.detail_bits = culling.detail;
  options.direction_rows = culling.directions;
  for (const std::string& file : basisFiles(culling))
    options.basis.push_back(readTransferFunction(file, volume.valueRange(), {}, interruption()));
  return options;
}

SeriesFunctions openFunctions(const IndexedVolume& volume, const TransferFunction& transfer,
                              const CullingArguments& culling, const ResourceArguments& resources,
                              WorkerPool& pool) {
  ProgressMeter progress(preparingLine(resources));
  SeriesFunctions functions =
      seriesFunctions(volume, transfer, seriesOptions(culling, volume),
                      {pool, progress, memoryBudget(resources), interruption()});
  if (!resources.quiet && !functions.note.empty()) printWarning(functions.note);
  return functions;
}

CullingOptions cullingOptions(Culling culling, const FrameOptions& frame,
                              const SeriesFunctions& functions) {
  CullingOptions options;
  options.form = culling == Culling::kPof ? OpacityForm::kPof : OpacityForm::kOpof;
  options.opacity_threshold = hidingThreshold(frame);
  options.uses_coherence = culling == Culling::kToc;
  options.clip_planes = frame.clip_planes;
  options.exponent = functions.exponent;
  return options;
}

Series::Series(Scene& scene, const CullingArguments& culling, const ResourceArguments& resources,
               const FrameOptions& frame)
    : scene_(scene), resources_(resources) {
  if (scene.share) scene.share->dealEachPicture(scene.volume.source->layout().time_steps > 1);
  if (culling.culling == Culling::kNone) return;
  scene.inTurn([&] {
    functions_.emplace(openFunctions(scene.volume, scene.transfer, culling, resources, scene.pool));
  });
  CullingOptions options = cullingOptions(culling.culling, frame, *functions_);
  openSession(scene, resources, frame, functions_->opacity()->bytes());
  if (scene.share) scene.share->shareEstimate(options);
  culled_.emplace(functions_->opacity(), scene.volume.source->layout(), options, scene.pool);
  scene.chooseBlocksBy(&*culled_);
}

Series::~Series() {
  if (culled_) scene_.chooseBlocksBy(nullptr);
}

TimeStep Series::step(int64_t time) {
  if (next_ && next_->time == time) return *next_;
  ProgressMeter progress;
  TimeStep step;
  scene_.inTurn([&] {
    step = stepOfSeries(scene_.volume, time,
                        {scene_.pool, progress, memoryBudget(resources_), interruption()});
  });
  if (scene_.share && time != scene_.volume.time)
    expectSameStep(scene_.share->team(), scene_, step);
  return step;
}

void Series::show(int64_t time, std::optional<int64_t> next) {
  scene_.session->setTimeStep(step(time));
  next_.reset();
  shown_ = time;
  if (!next) return;
  next_ = step(*next);
  scene_.session->expectAfterwards(*next_);
}

nlohmann::json countsJson(const CullingCounts& counts) {
  return {{"blocks_nonempty", counts.blocks_nonempty},
          {"visible", counts.blocks_visible},
          {"estimate_seconds", counts.estimate_seconds},
          {"pixels_checked", counts.pixels_checked},
          {"pixels", counts.pixels},
          {"changed_blocks", counts.changed_blocks}};
}

}  // namespace sluice
