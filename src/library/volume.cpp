#include <sluice/volume.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "io/lent_source.h"
#include "io/web/bucket_access.h"
#include "src/base/error.h"
#include "src/base/threads/mutex.h"
#include "src/base/values/value_counts.h"
#include "src/library/conversions.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/channel_looks.h"
#include "src/library/opening/checked_source.h"
#include "src/library/opening/opened_volume.h"

namespace sluice {
namespace {

// The notes of an open volume that its user should see. If no folder is named, nobody expects an
// index.
void addNotes(const IndexedVolume& volume, const IndexWish& wish, std::vector<std::string>& notes) {
  for (const std::string& note : volume.notes) {
    const bool is_expected = !(wish.folder.empty() && note == volume.index->note);
    if (is_expected && std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
  }
}

void setInfo(OpenedVolume& opened, const std::vector<std::string>& notes) {
  opened.info = volumeInfo(opened.volume.source->layout(), opened.volume.valueRange(), notes);
  if (!opened.more.empty()) opened.info.channels.push_back(opened.volume.channel.title());
  for (const IndexedVolume& volume : opened.more)
    opened.info.channels.push_back(volume.channel.title());
  opened.info.levels = static_cast<int>(opened.volume.step().coarser.size()) + 1;
  opened.info.was_opened_soon = opened.volume.was_hurried;
  opened.info.files = opened.volume.source->files();
}

// Lines that layers below tell while a volume is opened; later ones are dropped. Any thread.
class OpeningNotes {
 public:
  void add(const std::string& line) {
    const MutexLock lock(mutex_);
    if (!is_over_) lines_.push_back(line);
  }
  std::vector<std::string> take() {
    const MutexLock lock(mutex_);
    is_over_ = true;
    return std::move(lines_);
  }

 private:
  Mutex mutex_;
  std::vector<std::string> lines_ SLUICE_GUARDED_BY(mutex_);
  bool is_over_ SLUICE_GUARDED_BY(mutex_) = false;
};

// `channels` gives those of `arguments` that pictures show, once a call may tell how far it is.
template <class Channels>
void open(OpenedVolume& opened, VolumeArguments arguments, const VolumeOptions& options,
          const IndexWish& wish, ProgressTeller& teller, const Channels& channels) {
  const MachineOptions machine = machineOptions(options);
  opened.relay = std::make_shared<ProgressRelay>();
  // Shared pointers are captured: sources keep these functions long after this call.
  arguments.open.decode.watch = [relay = opened.relay](const std::string&) {
    return [relay](uint64_t done, uint64_t total) {
      relay->tell(Progress::Stage::kDecoding, done, total);
    };
  };
  const auto told = std::make_shared<OpeningNotes>();
  arguments.open.web.warn = [told](const std::string& line) { told->add(line); };
  const ProgressRelay::Call call(*opened.relay, teller);
  teller.stop().throwIfStopped();
  WorkerPool pool(machine.threads);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  IndexNeeds needs = kUsualNeeds;  // any look can be drawn
  needs.whole_series = options.whole_series;
  needs.opens_soon = options.opens_soon;
  opened.whole_series = options.whole_series;
  IndexPass pass{pool, progress, memoryBudget(machine), teller.stop()};
  std::vector<std::string> notes;
  std::vector<ChannelSource> sources = channels(arguments);
  const VolumeLayout first = sources.front().source->layout();
  for (ChannelSource& source : sources) {
    IndexNeeds own = needs;
    // Means of labels say nothing; their most frequent ones do.
    if (looksLikeLabels(source)) own.values = LevelValues::kModes;
    const MachineOptions own_machine = withBlocksOfFirst(machine, source.source->layout(), first);
    pass.together = source.together;
    IndexedVolume volume =
        indexVolume(std::move(source.source), source.arguments, own_machine, own, wish, pass);
    volume.channel = std::move(source.channel);
    std::ranges::move(source.notes, std::back_inserter(volume.notes));
    if (volume.stand_in) volume.notes.push_back(volume.standInNote());
    addNotes(volume, wish, notes);
    if (opened.volume.source == nullptr)
      opened.volume = std::move(volume);
    else
      opened.more.push_back(std::move(volume));
  }
  // Each channel has a store of its own, and they have one cache.
  for (std::string& line : told->take())
    if (std::ranges::find(notes, line) == notes.end()) notes.push_back(std::move(line));
  setInfo(opened, notes);
}

void openPart(OpenedVolume& opened, const LentPart& part, std::shared_ptr<Ranks::Impl> ranks,
              const VolumeOptions& options, ProgressTeller& teller) {
  const MachineOptions machine = machineOptions(options);
  opened.relay = std::make_shared<ProgressRelay>();
  const ProgressRelay::Call call(*opened.relay, teller);
  teller.stop().throwIfStopped();
  WorkerPool pool(machine.threads);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  VolumeArguments arguments;
  arguments.inputs = {part.layout.name};
  arguments.time = 0;
  SharedVolume shared = openShared(part, std::move(ranks), arguments, machine,
                                   {pool, progress, memoryBudget(machine), teller.stop()});
  opened.volume = std::move(shared.volume);
  opened.in_situ = std::move(shared.in_situ);
  std::vector<std::string> notes;
  addNotes(opened.volume, {.disabled = true}, notes);
  setInfo(opened, notes);
}

void openLent(OpenedVolume& opened, FillRegion fill, const VolumeLayout& layout,
              const VolumeOptions& options, const ProgressFunction& progress,
              const std::stop_token& stop) {
  translated([&] {
    ProgressTeller teller(progress, stop);
    VolumeArguments arguments;
    arguments.inputs = {layout.name};
    arguments.time = options.time;
    // Nobody can tell whether an index that was kept is of these voxels.
    open(opened, arguments, options, {.disabled = true}, teller, [&](const VolumeArguments& asked) {
      std::vector<ChannelSource> one(1);
      one.front().source = checkedSource(lentSource(std::move(fill), layout), asked);
      one.front().arguments = asked;
      return one;
    });
  });
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
    open(*impl, volumeArguments(paths, options), options, {.folder = options.index_folder}, teller,
         [](const VolumeArguments& arguments) { return openChannels(arguments); });
  });
  impl_ = std::move(impl);
}

Volume Volume::borrow(const void* first, const ArrayLayout& layout,
                      const std::optional<ArrayStrides>& strides, const VolumeOptions& options,
                      const ProgressFunction& progress, const std::stop_token& stop) {
  const VolumeLayout lent = volumeLayout(layout);
  FillRegion fill = fillFrom(first, lent, strides.value_or(packedStrides(lent)));
  auto impl = std::make_shared<Impl>();
  openLent(*impl, std::move(fill), lent, options, progress, stop);
  return Volume(std::move(impl));
}

Volume Volume::borrow(const void* first, const ArrayLayout& layout, const LentBox& box,
                      const Ranks& ranks, const std::optional<ArrayStrides>& strides,
                      const VolumeOptions& options, const ProgressFunction& progress,
                      const std::stop_token& stop) {
  if (ranks.impl_ == nullptr) failRequest("Ranks that were moved from: they are none any more");
  auto impl = std::make_shared<Impl>();
  translated([&] {
    ProgressTeller teller(progress, stop);
    together(ranks.impl_->team, [&] {
      openPart(*impl, {first, volumeLayout(layout), box, strides}, ranks.impl_, options, teller);
      return true;
    });
  });
  return Volume(std::move(impl));
}

Volume Volume::fromFunction(FillBox fill, const ArrayLayout& layout, const VolumeOptions& options,
                            const ProgressFunction& progress, const std::stop_token& stop) {
  const VolumeLayout lent = volumeLayout(layout);
  FillRegion region;
  if (fill)
    region = [fill = std::move(fill)](int64_t time, const Box3& box, std::span<std::byte> out) {
      fill(time, {box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}, out);
    };
  auto impl = std::make_shared<Impl>();
  openLent(*impl, std::move(region), lent, options, progress, stop);
  return Volume(std::move(impl));
}

ValueHistogram Volume::histogram(int bins) const {
  info();  // throws if there is none
  if (bins < 1) failRequest("a histogram of {} bins: must be at least 1", bins);
  const Histogram made = histogramOf(impl_->volume.values.counts, static_cast<size_t>(bins));
  return {made.range.lo, made.range.hi, made.counts};
}

VolumeOptions::Web Volume::bucketAccess(
    const std::function<std::string(const std::string& name)>& variable) {
  return translated([&] {
    return webAccess(sluice::bucketAccess([&](const char* name) { return variable(name); }));
  });
}

const VolumeInfo& Volume::info() const {
  if (impl_ == nullptr) failRequest("a Volume that was moved from: it is open no more");
  return impl_->info;
}

}  // namespace sluice
