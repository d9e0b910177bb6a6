#include "tools/scene/replay.h"

#include <fmt/format.h>

#include <utility>

#include "src/base/error.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/session/planner.h"
#include "src/texture/frame_trace.h"
#include "src/volume/block_side.h"
#include "tools/command_line/console.h"
#include "tools/options/shared_options.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

constexpr uint64_t kDefaultTracePages = 256;

class TraceFile final : public ReplaySource {
 public:
  TraceFile(std::string file, std::optional<TraceFormat> format, uint64_t page_bytes)
      : file_(std::move(file)), page_bytes_(page_bytes), format_(format) {}
  std::string title() const override { return file_; }
  uint64_t defaultPages() const override { return kDefaultTracePages; }
  std::optional<uint64_t> plannedPages(uint64_t /*pages*/) const override { return std::nullopt; }

  PreparedTrace requests(uint64_t /*pages*/) override {
    const auto reader = openTrace(file_, format_, page_bytes_);
    TracePreparer preparer(reader->pageBytes(), reader->carriesClusters());
    readInto(*reader, [&](const TraceRecord& record) { preparer.add(record); });
    PreparedTrace trace = preparer.finish();
    if (trace.resized > 0)
      warnings_.push_back(
          fmt::format("{}: {} of {} requests name another size than the first request of their "
                      "chunk; the first size counts",
                      file_, trace.resized, trace.keys.size()));
    return trace;
  }
  Trace records(uint64_t /*pages*/) override {
    Trace trace = readAll(*openTrace(file_, format_, page_bytes_));
    checkSome(trace.records.size());
    return trace;
  }
  uint64_t visit(uint64_t /*pages*/, const std::function<void(const TraceRecord&)>& take) override {
    const auto reader = openTrace(file_, format_, page_bytes_);
    readInto(*reader, take);
    return reader->pageBytes();
  }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  template <class Take>
  void readInto(TraceReader& reader, const Take& take) {
    TraceRecord record;
    size_t count = 0;
    for (; reader.next(record); ++count) take(record);
    checkSome(count);
    warnings_ = reader.warnings();
  }
  void checkSome(size_t count) const {
    if (count == 0) fail("{}: the trace holds no requests; is it cut?", file_);
  }

  const std::string file_;
  const uint64_t page_bytes_;
  const std::optional<TraceFormat> format_;
  std::vector<std::string> warnings_;
};

// A volume with the pictures of a turn around it.
struct TurnedVolume {
  std::unique_ptr<const IndexedVolume> volume;
  TransferPtr transfer;
  std::vector<Camera> cameras;
};

TurnedVolume openTurned(const TurnArguments& arguments, FinestLevel finest, WorkerPool& pool,
                        const Outputs& outputs) {
  TurnedVolume turned;
  turned.volume = std::make_unique<const IndexedVolume>(
      openIndexed(arguments.volume, arguments.resources,
                  pictureNeeds(arguments.look, arguments.frame, finest), pool, outputs));
  const IndexedVolume& volume = *turned.volume;
  turned.transfer = std::make_shared<const TransferFunction>(
      lookFor(volume, arguments.look, arguments.frame.mode).transfer);
  turned.cameras = turnOf(arguments.frame.camera, arguments.frames);
  fitCameras(
      turned.cameras, arguments.fit,
      {{{volume, volume.step(), *turned.transfer}}, arguments.frame, arguments.look.this_step}, {},
      arguments.resources, pool);
  return turned;
}

// Without the index of the finest level if no picture of the turn shows that level.
TurnedVolume openTurned(const TurnArguments& arguments, WorkerPool& pool, const Outputs& outputs) {
  TurnedVolume turned = openTurned(arguments, FinestLevel::kMayWait, pool, outputs);
  if (mustReadFinest(*turned.volume, *turned.transfer, turned.volume->source->layout(),
                     arguments.frame, turned.cameras, pool))
    return openTurned(arguments, FinestLevel::kRead, pool, outputs);
  if (turned.volume->stand_in && !arguments.resources.quiet)
    printWarning(turned.volume->standInNote());
  return turned;
}

class Turn final : public ReplaySource {
 public:
  Turn(const TurnArguments& arguments, const Outputs& outputs)
      : arguments_(arguments),
        pool_(arguments.resources.threads),
        turned_(openTurned(arguments, pool_, outputs)),
        volume_(*turned_.volume),
        default_pages_(static_cast<uint64_t>(volume_.page.pages)) {
    if (arguments_.fixed_pages == 0) arguments_.fixed_pages = default_pages_;
  }
  std::string title() const override { return volume_.source->layout().name; }
  uint64_t defaultPages() const override { return default_pages_; }
  uint64_t leastPages() const override {
    const int64_t side = blockSide(volume_.layout, volume_.source->layout().levels);
    return static_cast<uint64_t>(volume_.numbers() * volume_.page.pagesOf({side, side, side}));
  }
  std::optional<uint64_t> plannedPages(uint64_t pages) const override {
    return arguments_.is_plan_fixed ? arguments_.fixed_pages : pages;
  }

  PreparedTrace requests(uint64_t pages) override { return prepare(records(pages)); }
  uint64_t visit(uint64_t pages, const std::function<void(const TraceRecord&)>& take) override {
    const Trace trace = records(pages);
    for (const TraceRecord& record : trace.records) take(record);
    return trace.page_bytes;
  }
  Trace records(uint64_t pages) override {
    PageGeometry page = volume_.page;
    page.pages = static_cast<int64_t>(*plannedPages(pages));
    const VolumeLayout& layout = volume_.source->layout();
    ChunkNames names;
    Planner planner(page, pool_, names);
    Trace trace;
    trace.page_bytes = static_cast<uint64_t>(page.pageBytes());
    FrameOptions options = arguments_.frame;
    for (int64_t frame = 0; frame < arguments_.frames; ++frame) {
      options.camera = turned_.cameras[static_cast<size_t>(frame)];
      const View view = resolve(options.camera, layout, options.size, options.step_vox);
      const FramePlanPtr plan = planner.planFor(volume_.step(), turned_.transfer, options);
      const auto requests =
          frameRequests(plan->textures, plan->names, eyePosition(view, layout), frame);
      trace.records.insert(trace.records.end(), requests.begin(), requests.end());
    }
    return trace;
  }

 private:
  TurnArguments arguments_;
  Workers pool_;
  const TurnedVolume turned_;
  const IndexedVolume& volume_;
  const uint64_t default_pages_;
};

}  // namespace

std::unique_ptr<ReplaySource> openTraceFile(const std::string& file,
                                            std::optional<TraceFormat> format,
                                            uint64_t page_bytes) {
  return std::make_unique<TraceFile>(file, format, page_bytes);
}

std::unique_ptr<ReplaySource> openTurn(const TurnArguments& arguments, const Outputs& outputs) {
  TurnArguments turn = arguments;
  turn.frame.cut = cutOptions(turn.levels, turn.resources, turn.look, turn.frame,
                              turn.frames == 1 ? PictureRow::kOne : PictureRow::kMore);
  return std::make_unique<Turn>(turn, outputs);
}

}  // namespace sluice
