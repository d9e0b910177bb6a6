#include "tools/scene/series.h"

#include <algorithm>
#include <limits>
#include <sstream>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/library/opening/step_ranges.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/scene/rank_agreement.h"

namespace sluice {
namespace {

// Share of the time without culling: the saving must exceed the difference of two measurements.
constexpr double kWorthwhile = 0.9;
// Fewer hidden blocks than this share of those that are not empty cannot save that much.
constexpr double kLeastHidden = 0.05;

ProgressWatch preparingLine(const ResourceArguments& resources) {
  return resources.quiet ? ProgressWatch() : progressLine("preparing");
}

// The functions that the index has; auto computes no others.
std::optional<SeriesFunctions> preparedFunctions(Scene& scene, const CullingArguments& culling,
                                                 const ResourceArguments& resources) {
  ProgressMeter progress;
  std::optional<SeriesFunctions> functions =
      keptSeriesFunctions(scene.volume, scene.look.transfer, seriesOptions(culling, scene.volume),
                          passOf(scene.pool, progress, resources));
  if (functions && !resources.quiet && !functions->note.empty()) printWarning(functions->note);
  return functions;
}

}  // namespace

std::vector<std::string> basisFiles(const CullingArguments& culling) {
  std::vector<std::string> names;
  std::istringstream files(culling.basis);
  for (std::string file; std::getline(files, file, ',');) names.push_back(file);
  return names;
}

void checkBasis(const CullingArguments& culling) {
  for (const std::string& file : basisFiles(culling)) {
    if (file.empty())
      failRequest("--basis {}: expected names of files with commas between", culling.basis);
    // Any range serves, since only the file's form is looked at.
    readTransferFunction(file, {0, 1}, {}, interruption());
  }
}

SeriesOptions seriesOptions(const CullingArguments& culling, const IndexedVolume& volume) {
  if (culling.part % kDetail != 0)
    failRequest("--part {}: a part has {} cubes a side; give a multiple of {}", culling.part,
                kDetail, kDetail);
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
  SeriesFunctions functions = seriesFunctions(volume, transfer, seriesOptions(culling, volume),
                                              passOf(pool, progress, resources));
  if (!resources.quiet && !functions.note.empty()) printWarning(functions.note);
  return functions;
}

CullingOptions cullingOptions(Culling culling, const FrameOptions& frame,
                              const SeriesFunctions& functions, uint64_t memory_bytes) {
  constexpr uint64_t kKeptShare = 8;
  CullingOptions options;
  options.most_kept_bytes = std::min(options.most_kept_bytes, memory_bytes / kKeptShare);
  options.form = culling == Culling::kPof ? OpacityForm::kPof : OpacityForm::kOpof;
  options.opacity_threshold = hidingThreshold(frame);
  options.uses_coherence = culling == Culling::kToc || culling == Culling::kAuto;
  options.clip_planes = frame.clip_planes;
  options.exponent = functions.exponent;
  return options;
}

Series::Series(Scene& scene, const CullingArguments& culling, const ResourceArguments& resources,
               const FrameOptions& frame)
    : scene_(scene), frame_(frame), is_auto_(culling.culling == Culling::kAuto) {
  // Visible blocks differ from channel to channel, so blended ones are dealt as the volume is.
  for (Layer* layer : scene.layers())
    if (layer->share)
      layer->share->dealEachPicture(!scene.blends() &&
                                    layer->volume.source->layout().time_steps > 1);
  if (culling.culling != Culling::kNone && !scene.more.empty())
    failRequest("{}: --culling looks at one channel, {}", scene.volume.name, scene.notOneChannel());
  if (is_auto_ && scene.share)
    failRequest("--culling auto measures one process; give ranks --culling toc or none");
  if (culling.culling != Culling::kNone)
    scene.inTurn([&] {
      if (is_auto_)
        functions_ = preparedFunctions(scene, culling, resources);
      else
        functions_.emplace(
            openFunctions(scene.volume, scene.look.transfer, culling, resources, scene.pool));
    });
  if (!functions_) return;
  const auto optionsWith = [&](uint64_t memory_bytes) {
    return cullingOptions(culling.culling, frame, *functions_, memory_bytes);
  };
  const SeriesOpacity& opacity = *functions_->opacity();
  // The functions take memory beside the session, which has to be opened with less.
  scene.openSession(frame, [&](uint64_t memory_bytes) {
    return opacity.bytes() + CulledBlocks::mostBytes(opacity, frame.size, optionsWith(memory_bytes),
                                                     scene.pool.threads());
  });
  CullingOptions options = optionsWith(scene.memory_bytes);
  if (scene.share) scene.share->shareEstimate(options);
  culled_.emplace(functions_->opacity(), scene.volume.source->layout(), options, scene.pool);
  if (!is_auto_) scene.chooseBlocksBy(&*culled_);
}

void Series::choose(std::span<const int64_t> times) {
  if (!is_auto_) return;
  choice_ = measure(times);
  if (!choice_->culls) {
    culled_.reset();
    functions_.reset();
  }
  scene_.chooseBlocksBy(culled_ ? &*culled_ : nullptr);
}

CullingChoice Series::measure(std::span<const int64_t> times) {
  CullingChoice choice;
  if (!functions_) {
    choice.line = "none: the series is not prepared; sluice prepare does it";
    return choice;
  }
  if (times.size() < kLeastMeasured) {
    choice.line = fmt::format(
        "none: only series of {} steps or more are measured; give toc if reading a step "
        "takes longer than drawing it",
        kLeastMeasured);
    return choice;
  }
  double none = std::numeric_limits<double>::infinity(), culled = none;
  // The first picture warms up and does not count.
  secondsOf(times[0], true);
  const CullingCounts& first = culled_->countsOf(times[0]);
  const int64_t hidden = first.blocks_nonempty - first.blocks_visible;
  if (static_cast<double>(hidden) < kLeastHidden * static_cast<double>(first.blocks_nonempty)) {
    scene_.session->forgetLastFrame();
    choice.line =
        fmt::format("none: it hides {} of the first step's {} blocks, too few to save time", hidden,
                    first.blocks_nonempty);
    return choice;
  }
  // The ways take turns, and the least of two counts, so that neither has the quieter moments.
  for (const size_t i : {1, 3}) {
    none = std::min(none, secondsOf(times[i], false));
    culled = std::min(culled, secondsOf(times[i + 1], true));
  }
  scene_.session->forgetLastFrame();
  choice.none_seconds = none;
  choice.culled_seconds = culled;
  choice.culls = culled < kWorthwhile * none;
  choice.line =
      fmt::format("{}: a step took {:.3f} s with it, {:.3f} s without",
                  choice.culls ? "toc" : "none", *choice.culled_seconds, *choice.none_seconds);
  return choice;
}

double Series::secondsOf(int64_t time, bool culls) {
  scene_.chooseBlocksBy(culls ? &*culled_ : nullptr);
  const Stopwatch watch;
  show(time, std::nullopt);
  scene_.draw(scene_.stripsOf(frame_), [](const Picture& /*rows*/) {});
  return watch.seconds();
}

Series::~Series() {
  if (culled_) scene_.chooseBlocksBy(nullptr);
}

const std::vector<TimeStep>& Series::steps(int64_t time) {
  // The step was made ready while the one before was drawn.
  if (!next_.empty() && next_.front().time == time) return next_;
  ProgressMeter progress;
  std::vector<TimeStep> steps;
  scene_.inTurn([&] {
    for (const Layer* layer : scene_.layers())
      steps.push_back(stepOfSeries(layer->volume, time, passOf(scene_, progress)));
  });
  if (scene_.share && time != scene_.volume.time)
    expectSameStep(scene_.share->team(), scene_, steps);
  next_ = std::move(steps);
  return next_;
}

void Series::show(int64_t time, std::optional<int64_t> next) {
  scene_.setTimeStep(steps(time));
  next_.clear();
  shown_ = time;
  if (!next) return;
  scene_.expectAfterwards(steps(*next));
}

nlohmann::json choiceJson(const CullingChoice& choice) {
  nlohmann::json json{{"culls", choice.culls}, {"line", choice.line}};
  if (choice.none_seconds)
    json["seconds"] = {{"none", *choice.none_seconds}, {"toc", *choice.culled_seconds}};
  return json;
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
