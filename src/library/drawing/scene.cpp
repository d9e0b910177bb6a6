#include "src/library/drawing/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/empty_picture.h"
#include "src/render/blocks/level_cut.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/session/planner.h"

namespace sluice {
namespace {

// The finest level in the picture.
int finestLevelOf(const Scene& scene, const TimeStep& step, const View& view,
                  const FrameOptions& options) {
  const TransferFunction& transfer = scene.look.transfer;
  if (!drawsCut(step, options.cut, options.mode, transfer.labels)) return 0;
  if (!options.cut->keeps_thin) return finestLevelShown(step, view, *options.cut);
  // Thin parts may be refined anywhere, which the cut alone tells.
  ChunkNames names;
  Planner planner(scene.page, scene.pool, names);
  const LookPtr look =
      planner.look(step, std::make_shared<const TransferFunction>(transfer), options.mode);
  const VisibleBlocksPtr blocks = planner.visibleBlocks(step, look, view, options);
  return blocks->cut->levels.empty() ? 0 : blocks->cut->levels.front().level;
}

// Ranks have parts in the picture's place, and the first one the picture.
uint64_t composedBytes(uint64_t part_bytes, PictureSize size, uint64_t memory_bytes) {
  const uint64_t bytes = part_bytes + static_cast<uint64_t>(size.width) *
                                          static_cast<uint64_t>(size.height) * kComposedPixelBytes;
  if (bytes > memory_bytes)
    fail(
        "--memory {} is too small: the picture takes {} on each rank; give more --memory or a "
        "smaller --size",
        formatBytes(memory_bytes), formatBytes(bytes));
  return bytes;
}

}  // namespace

uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool) {
  // A series also holds the ranges of the step that is shown and of the next one.
  const uint64_t steps = volume.source->layout().time_steps > 1 ? 3 : 1;
  return steps * volume.rangesBytes() + planBytes(volume, transfer, frame, pool);
}

Scene::Scene(SceneInputs inputs, const LookArguments& asked, const FrameOptions& frame)
    : owned_pool(std::move(inputs.pool)),
      owned_volume(std::move(inputs.volume)),
      pool(*owned_pool),
      volume(*owned_volume),
      machine(std::move(inputs.machine)),
      may_be_lit(inputs.may_be_lit),
      memory_bytes(memoryBudget(machine)),
      page(volume.page),
      device(makeDevice(machine.device, pool)),
      look(lookFor(volume, asked, frame.mode)) {
  if (inputs.team != nullptr) {
    const int level = frame.cut ? frame.cut->level.value_or(0) : 0;
    const Dealing dealing = dealBlocks(volume.step().layout(), inputs.team->ranks(), level);
    part_bytes = partBytes(frame.size, dealing, memory_bytes);
    share = std::make_unique<RankShare>(*inputs.team, dealing, pool, part_bytes);
    device = share->deviceFrom(std::move(device));
  }
  openSession(frame, 0);
  noteMemory();
}

void Scene::openSession(const FrameOptions& frame, uint64_t more_bytes) {
  const uint64_t others_bytes = othersBytes(volume, look.transfer, frame, pool) + more_bytes;
  BesideShare beside =
      besideShare(volume, machine, frame.partition, pictureDemand(machine, frame), others_bytes);
  if (share) {
    beside.beside_bytes = others_bytes + composedBytes(part_bytes, frame.size, memory_bytes);
    beside.pages = pageCount(machine, volume, beside.beside_bytes);
  } else {
    part_bytes = beside.picture_bytes;
  }
  page.pages = beside.pages;
  beside_bytes = beside.beside_bytes;
  SessionOptions options =
      sessionOptions(volume, may_be_lit || look.lit, machine, frame.partition, memory_bytes);
  options.page = page;
  options.beside_bytes = beside_bytes;
  session.reset();
  session = std::make_unique<Session>(volume.step(), *device, pool, options);
  session->setTransferFunction(look.transfer);
  chooseBlocksBy(nullptr);
}

void Scene::setLook(const LookArguments& asked, Mode mode) {
  ChosenLook chosen = lookFor(volume, asked, mode);
  session->setTransferFunction(chosen.transfer);
  look = std::move(chosen);
}

void Scene::chooseBlocksBy(BlockChooser* chooser) {
  if (session != nullptr) session->chooseBlocksBy(share ? share->chooserFrom(chooser) : chooser);
}

double Scene::chosenStep(const TimeStep& step, const FrameOptions& options) const {
  if (!traitsOf(options.mode).has_colors) return options.step_vox;
  const View view =
      resolve(options.camera, volume.source->layout(), options.size, options.step_vox);
  const double chosen = stepFor(view, step, finestLevelOf(*this, step, view, options));
  if (!options.integrates || drawsCut(step, options.cut, options.mode, look.transfer.labels))
    return chosen;
  // As long as frames may integrate.
  const double most =
      options.step_vox * kMostIntegratedStep / longestStep(view, volume.source->layout());
  return std::min(chosen * options.step_factor, most);
}

std::string Scene::lookOf(const FrameOptions& options) const {
  if (!traitsOf(options.mode).has_colors) return look.options;
  return look.options + fmt::format(" --step {}", options.step_vox) +
         (options.integrates ? " --quality normal" : "");
}

std::vector<PictureRows> Scene::stripsOf(const FrameOptions& frame) const {
  if (share) return {{0, frame.size.height}};
  const PictureDemand picture = pictureDemand(machine, frame);
  return sluice::stripsOf(picture, part_bytes >= leastPictureBytes(picture)
                                       ? part_bytes
                                       : pictureBytes(picture, memory_bytes));
}

SceneFrame Scene::draw(const std::vector<PictureRows>& strips,
                       const std::function<void(const Picture& rows)>& take) {
  SceneFrame drawn;
  const auto drawNext = [&] {
    Frame next = frame();
    noteMemory();
    drawn.shows_something = drawn.shows_something || !showsNothing(next.picture);
    if (drawn.blocks == nullptr) {
      drawn.blocks = next.blocks;
      drawn.report = next.report;
    } else {
      addStrip(drawn.report, next.report);
    }
    take(next.picture);
    return next;
  };
  if (strips.size() == 1) {
    drawn.whole = drawNext();
    return drawn;
  }
  StripsOfDevice rows(*device);
  for (const PictureRows& strip : strips) {
    rows.draw(strip);
    device->reuse(std::move(drawNext().picture));
  }
  return drawn;
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

std::string Scene::whyNothing(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                              const IndexPass& pass) const {
  if (frame.shows_something) return "";
  return whyEmpty({volume, time, look.transfer, options, frame.report.missing_share}, pass);
}

void Scene::recordTo(const std::string& path) {
  session->recordTo(nullptr);
  if (trace != nullptr) trace->finish();
  trace.reset();
  if (path.empty()) return;
  trace = makeTraceWriter(path, traceFormatOf(path), static_cast<uint64_t>(page.pageBytes()));
  session->recordTo(trace.get());
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
