#include "src/library/drawing/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "src/base/error.h"
#include "src/base/files/file_kind.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/empty_picture.h"
#include "src/library/drawing/files/channel_traces.h"
#include "src/library/drawing/scene/refined_frame.h"
#include "src/library/opening/channel_looks.h"
#include "src/options/option_words.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/camera/frame_setup.h"

namespace sluice {
Scene::Scene(SceneInputs inputs, const LookArguments& asked_look, const FrameOptions& frame)
    : Layer(std::move(inputs.volume), shareOf(inputs.machine, 1 + inputs.more.size())),
      owned_pool(std::move(inputs.pool)),
      pool(*owned_pool),
      may_be_lit(inputs.may_be_lit),
      memory_bytes(memoryBudget(inputs.machine)),
      asked(asked_look),
      device(makeDevice(machine.device, pool)) {
  requirePictureSize(frame.size, device->limits());
  for (auto& further : inputs.more)
    more.push_back(std::make_unique<Layer>(std::move(further), machine));
  requireShown(asked, shownChannels());
  requireBlendable(asked, frame, looks());
  for (Layer* layer : layers()) layer->look = lookFor(layer->volume, asked, frame.mode);
  setCombining(frame);
  drawn_look = lookText();
  if (inputs.team != nullptr) {
    for (Layer* layer : layers())
      shareAmong(*inputs.team, inputs.lent, *layer, optionsOf(*layer, frame));
    device = share->deviceFrom(std::move(device));
  }
  openSession(frame, noMoreBytes);
  noteMemory();
}

Scene::~Scene() {
  // Sessions draw on the device, which is a member here and would be destroyed before the base
  // class's session.
  more.clear();
  session.reset();
}

std::vector<Layer*> Scene::layers() {
  std::vector<Layer*> all{this};
  for (const auto& further : more) all.push_back(further.get());
  return all;
}

std::string Scene::notOneChannel() const {
  return notOne(layers().size(), layers().back()->volume.channel);
}

std::vector<const Layer*> Scene::layers() const {
  std::vector<const Layer*> all{this};
  for (const auto& further : more) all.push_back(further.get());
  return all;
}

void Scene::shareAmong(Team& team, std::shared_ptr<const LentBoxes> lent, Layer& layer,
                       const FrameOptions& frame) {
  const int level = frame.cut ? frame.cut->level.value_or(0) : 0;
  // A rank has all channels of a block that are blended there.
  const IndexedVolume& dealt = blends() ? volume : layer.volume;
  const Dealing dealing = lent != nullptr ? dealLent(std::move(lent))
                                          : dealBlocks(dealt.step().layout(), team.ranks(), level);
  layer.part_bytes = partBytes(frame.size, dealing, memoryBudget(layer.machine));
  layer.share = std::make_unique<RankShare>(team, dealing, pool, layer.part_bytes);
}

void Scene::openSession(const FrameOptions& frame, const MoreBytes& more_bytes) {
  // All memory is free before it is shared out anew.
  for (Layer* layer : layers()) {
    if (layer->session != nullptr) layer->next_in_trace = layer->session->nextInTrace();
    layer->session.reset();
  }
  try {
    const std::vector<BesideShare> shares = sharesOf(frame, more_bytes, memory_bytes);
    for (size_t i = 0; i < shares.size(); ++i) {
      Layer& layer = *layers()[i];
      if (!layer.share) layer.part_bytes = shares[i].picture_bytes;
      layer.page.pages = shares[i].pages;
      layer.beside_bytes = shares[i].beside_bytes;
    }
    for (Layer* layer : layers()) openSession(*layer, frame.partition);
    opened_to_blend_ = blends();
  } catch (const Error& error) {
    for (Layer* opened : layers()) opened->session.reset();  // none outlives the device
    const auto needOf = [&](uint64_t memory) { return needOfMemory(frame, more_bytes, memory); };
    std::optional<uint64_t> least;
    if (dynamic_cast<const MemoryShortage*>(&error) != nullptr)
      least = leastMemoryBytes(needOf, memory_bytes);
    // A rank's part of the picture, which is known when it is drawn, takes more than the least and
    // seldom as much as is enough for any.
    if (least && share)
      failMemory(
          "--memory {} is too small: each rank needs at least {}, and {} is enough for any picture "
          "of this size{}; give more --memory or a smaller --size",
          formatBytes(memory_bytes), *least, enoughForRanks(frame, more_bytes, *least),
          layers().size() > 1
              ? fmt::format(" ({} channels share the memory evenly)", layers().size())
              : "");
    failOfShare(error, layers().size(), least);
  }
}

void Scene::openSession(Layer& layer, Partition partition) {
  const IndexedVolume& of = layer.volume;
  SessionOptions options = sessionOptions(of, may_be_lit || layer.look.lit, machine, partition,
                                          memoryBudget(layer.machine));
  options.page = layer.page;
  options.beside_bytes = layer.beside_bytes;
  options.trace_from = layer.next_in_trace;
  layer.session = std::make_unique<Session>(of.step(), *device, pool, options);
  layer.session->recordTo(layer.trace.get());
  layer.session->setTransferFunction(layer.look.transfer);
  if (layer.share) layer.session->chooseBlocksBy(layer.share->chooserFrom(nullptr));
}

void Scene::setLook(const LookArguments& asked_look, const FrameOptions& frame) {
  // All looks are made before one is set, so that an invalid one leaves the scene as it was.
  std::vector<ChosenLook> chosen;
  for (const Layer* layer : layers())
    chosen.push_back(lookFor(layer->volume, asked_look, frame.mode));
  requireShown(asked_look, shownChannels());
  requireBlendable(asked_look, frame, looks());
  asked = asked_look;
  for (size_t i = 0; i < chosen.size(); ++i) {
    Layer& layer = *layers()[i];
    // Without a session after a failure, the next one gets the look.
    if (layer.session != nullptr) layer.session->setTransferFunction(chosen[i].transfer);
    layer.look = std::move(chosen[i]);
  }
  setCombining(frame);
  drawn_look = lookText();
}

void Scene::setCombining(const FrameOptions& frame) {
  combine = combineOf(asked, frame, looks());
  why_added = addedNote(asked, frame, looks());
}

void Scene::setOptions(const FrameOptions& options) {
  requireBlendable(asked, options, looks());
  for (Layer* layer : layers()) layer->session->setOptions(optionsOf(*layer, options));
}

void Scene::setTimeStep(const std::vector<TimeStep>& steps) {
  SLUICE_CHECK_EQ(steps.size(), layers().size());
  for (size_t i = 0; i < steps.size(); ++i) layers()[i]->session->setTimeStep(steps[i]);
}

void Scene::expectAfterwards(const std::vector<TimeStep>& steps) {
  SLUICE_CHECK_EQ(steps.size(), layers().size());
  for (size_t i = 0; i < steps.size(); ++i) layers()[i]->session->expectAfterwards(steps[i]);
}

LevelCounters countersOf(const Session& session) {
  const TextureCache& cache = session.textureCache();
  return {session.volumeBufferCounters(), session.textureBufferCounters(), cache.counters(),
          cache.capacityPages(), cache.pagesLoaded()};
}

LevelCounters Scene::levelCounters() const {
  LevelCounters sum;
  for (const Layer* layer : layers()) {
    const LevelCounters of_layer = countersOf(*layer->session);
    sum.volume_buffer += of_layer.volume_buffer;
    sum.texture_buffer += of_layer.texture_buffer;
    sum.texture_cache += of_layer.texture_cache;
    sum.pages += of_layer.pages;
    sum.pages_loaded += of_layer.pages_loaded;
  }
  return sum;
}

uint64_t Scene::storedBytesRead() const {
  uint64_t bytes = 0;
  for (const Layer* layer : layers()) bytes += layer->volume.source->storedBytesRead();
  return bytes;
}

void Scene::chooseBlocksBy(BlockChooser* chooser) {
  if (session != nullptr) session->chooseBlocksBy(share ? share->chooserFrom(chooser) : chooser);
}

std::string Scene::lookText() const {
  if (more.empty()) return look.options();
  return lookOptions(asked, shownChannels(), look);
}

std::string Scene::lookOf(const FrameOptions& options, const PictureOptions& picture) const {
  std::string text = lookText();
  if (stepCounts(options.mode, options.step_vox))
    text += fmt::format(" --step {}", options.step_vox);
  // Other modes know no light.
  if (!traitsOf(options.mode).has_colors) return text;
  ViewState state;
  static_cast<PictureOptions&>(state) = picture;
  const bool is_lit = std::ranges::any_of(layers(), [](const Layer* of) { return of->look.lit; });
  state.look.light = is_lit ? LookOptions::Light::kOn : LookOptions::Light::kOff;
  return text + (integrates(options) ? " --quality normal" : "") + optionsText(lightWords(state));
}

bool Scene::integrates(const FrameOptions& options) const {
  return !blends() && integratesSamples(options, {&volume, &look.transfer});
}

PictureDemand Scene::demandOf(const FrameOptions& frame) const {
  FrameOptions own = frame;
  if (own.strips == Strips::kUnlessRefined && !canRefine(*this, own)) own.strips = Strips::kMayBe;
  return pictureDemand(machine, own);
}

std::vector<PictureRows> Scene::stripsOf(const FrameOptions& frame) const {
  if (share) return {{0, frame.size.height}};
  const PictureDemand picture = demandOf(frame);
  return sluice::stripsOf(picture, part_bytes >= leastPictureBytes(picture)
                                       ? part_bytes
                                       : pictureBytes(picture, memory_bytes));
}

SceneFrame Scene::draw(const std::vector<PictureRows>& strips,
                       const std::function<void(const Picture& rows)>& take) {
  SceneFrame drawn;
  const auto drawNext = [&] {
    std::vector<LayerFrame> parts;
    Frame next = frame(&parts);
    noteMemory();
    drawn.layers.resize(parts.size());
    for (size_t i = 0; i < parts.size(); ++i) {
      LayerFrame& layer = drawn.layers[i];
      if (drawn.blocks == nullptr)
        layer.report = parts[i].report;
      else
        addStrip(layer.report, parts[i].report);
      layer.shows_something = layer.shows_something || parts[i].shows_something;
      drawn.shows_something = drawn.shows_something || parts[i].shows_something;
    }
    if (drawn.blocks == nullptr) {
      drawn.blocks = next.blocks;
      drawn.report = next.report;
    } else {
      addStrip(drawn.report, next.report);
    }
    take(next.picture);
    return next;
  };
  // The one strip is the whole picture, which the caller gets with the report.
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

Frame Scene::frame(std::vector<LayerFrame>* of_layers) {
  std::vector<LayerFrame> own;
  if (of_layers == nullptr) of_layers = &own;
  composited = {};
  if (blends()) return drawBlended(*of_layers);
  if (!more.empty()) return drawLayers(*of_layers);
  Frame frame = nextFrame(*this);
  *of_layers = {{frame.report, !showsNothing(frame.picture)}};
  return frame;
}

Frame Scene::nextFrame(Layer& layer) {
  return composed(layer, [&] { return layer.session->frame(); });
}

Frame Scene::composed(Layer& layer, const std::function<Frame()>& draw_own) {
  if (!layer.share) return draw_own();
  layer.share->drawOn(share->device());
  Frame frame = draw_own();
  frame.picture = layer.share->picture();
  if (frame.report.cut) {
    CutSummary& cut = *frame.report.cut;
    cut.spread.reset();  // of this rank's blocks alone
    if (cut.thin_change) {
      // Voxels change the count of thin blocks only as a rank reads them, so the count of all is
      // known after the picture alone.
      const int64_t change = layer.share->sumOverRanks(*cut.thin_change);
      cut.thin_blocks += change - *cut.thin_change;
      cut.thin_change = change;
    }
  }
  frame.report.seconds += layer.share->report().seconds();
  composited += layer.share->report();
  return frame;
}

std::string Scene::whyNothing(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                              const IndexPass& pass) const {
  if (frame.shows_something) return "";
  return whyEmpty({volume, time, look.transfer, options, frame.report.missing_share}, pass);
}

std::vector<const ShownChannel*> Scene::shownChannels() const {
  std::vector<const ShownChannel*> shown;
  for (const Layer* layer : layers()) shown.push_back(&layer->volume.channel);
  return shown;
}

std::vector<std::string> Scene::tracePaths(const std::string& path) const {
  return channelTraces(path, shownChannels());
}

void Scene::requireNoOtherFiles(const std::string& path) const {
  if (more.empty()) return;
  for (const std::string& file : tracePaths(path))
    if (std::filesystem::exists(file) && !mayReplace(file, FileKind::kTrace))
      failRequest("{}: exists and is not {}; give another name", file, nameOf(FileKind::kTrace));
}

void Scene::recordTo(const std::string& path) {
  const std::vector<Layer*> all = layers();
  for (Layer* layer : all) {
    if (layer->session != nullptr) layer->session->recordTo(nullptr);
    if (layer->trace != nullptr) layer->trace->finish();
    layer->trace.reset();
  }
  if (path.empty()) return;
  const std::vector<std::string> paths = tracePaths(path);
  // All files are opened before one session records, so that a failure leaves none half set up.
  std::vector<std::unique_ptr<TraceWriter>> writers;
  for (size_t i = 0; i < all.size(); ++i)
    writers.push_back(makeTraceWriter(paths[i], traceFormatOf(paths[i]),
                                      static_cast<uint64_t>(all[i]->page.pageBytes())));
  for (size_t i = 0; i < all.size(); ++i) {
    all[i]->trace = std::move(writers[i]);
    all[i]->session->recordTo(all[i]->trace.get());
  }
}

void Scene::keepLearntRanges() const {
  for (const Layer* layer : layers()) {
    const IndexedVolume& of = layer->volume;
    // Ranges that are known from an index need no keeping.
    if (!of.stand_in || layer->session == nullptr) continue;
    const std::shared_ptr<const SliceRanges> learnt = layer->session->learntRanges();
    if (learnt != nullptr && learnt->unknown.size() < of.index->ranges.unknown.size())
      keepLearnt(*of.source, of.places, of.time, *learnt);
  }
}

void Scene::noteMemory() {
  peak_anonymous_bytes = std::max(peak_anonymous_bytes, anonymousBytes());
}

}  // namespace sluice
