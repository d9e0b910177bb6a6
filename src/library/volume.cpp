#include <sluice/volume.h>

#include <utility>

#include "src/base/error.h"
#include "src/base/values/value_counts.h"
#include "src/library/conversions.h"
#include "src/library/opened_volume.h"
#include "src/library/resources.h"

namespace sluice {
namespace {

void open(OpenedVolume& opened, const std::vector<std::string>& paths, const VolumeOptions& options,
          ProgressTeller& teller) {
  VolumeArguments arguments = volumeArguments(paths, options);
  const MachineOptions machine = machineOptions(options);
  opened.relay = std::make_shared<ProgressRelay>();
  arguments.open.decode.watch = [relay = opened.relay](const std::string&) {
    return [relay](uint64_t done, uint64_t total) {
      relay->tell(Progress::Stage::kDecoding, done, total);
    };
  };
  const ProgressRelay::Call call(*opened.relay, teller);
  teller.stop().throwIfStopped();
  WorkerPool pool(machine.threads);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  IndexNeeds needs = kUsualNeeds;  // any look can be drawn
  needs.whole_series = options.whole_series;
  opened.whole_series = options.whole_series;
  opened.volume = indexVolume(openSource(arguments), arguments, machine, needs,
                              {.folder = options.index_folder},
                              {pool, progress, memoryBudget(machine), teller.stop()});
  std::vector<std::string> notes = opened.volume.notes;
  // If no folder is named, nobody expects an index.
  if (options.index_folder.empty()) std::erase(notes, opened.volume.index->note);
  opened.info = volumeInfo(opened.volume.source->layout(), opened.volume.valueRange(), notes);
  opened.info.levels = static_cast<int>(opened.volume.step().coarser.size()) + 1;
  opened.info.files = opened.volume.source->files();
}

}  // namespace

Volume::Volume(const std::string& path, const VolumeOptions& options,
               const ProgressFunction& progress, const std::stop_token& stop)
    : Volume(std::vector<std::string>{path}, options, progress, stop) {}

Volume::Volume(const std::vector<std::string>& paths, const VolumeOptions& options,
               const ProgressFunction& progress, const std::stop_token& stop) {
  auto impl = std::make_shared<Impl>();
  translated([&] {
    ProgressTeller teller(progress, stop);
    open(*impl, paths, options, teller);
  });
  impl_ = std::move(impl);
}

ValueHistogram Volume::histogram(int bins) const {
  info();  // throws if there is none
  if (bins < 1) fail("a histogram of {} bins: must be at least 1", bins);
  const Histogram made = histogramOf(impl_->volume.values.counts, static_cast<size_t>(bins));
  return {made.range.lo, made.range.hi, made.counts};
}

const VolumeInfo& Volume::info() const {
  if (impl_ == nullptr) fail("a Volume that was moved from: it is open no more");
  return impl_->info;
}

}  // namespace sluice
