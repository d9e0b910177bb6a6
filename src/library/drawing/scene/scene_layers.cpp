// How the layers of a scene become one picture: each with its own options, added up or blended.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/pictures/screen_picture.h"
#include "src/library/drawing/empty_picture.h"
#include "src/library/drawing/scene/added_pictures.h"
#include "src/library/drawing/scene/scene.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/render/frame/loaded_boxes.h"
#include "src/render/session/blended_frame.h"

namespace sluice {
namespace {

// Depths of a volume over the first one, in the first one's unit.
void toUnitOf(const VolumeLayout& first, const VolumeLayout& own, std::vector<float>& depths) {
  const auto scale = static_cast<float>(worldScale(own, first));
  if (scale != 1)
    for (float& depth : depths) depth *= scale;
}

// Counts what a layer uploads while this exists, also for a frame that is given up.
class UploadsOf {
 public:
  UploadsOf(Layer& layer, const Device& device)
      : layer_(layer), device_(device), before_(device.uploadedBytes()) {}
  ~UploadsOf() { layer_.uploaded_bytes += device_.uploadedBytes() - before_; }
  UploadsOf(const UploadsOf&) = delete;
  UploadsOf& operator=(const UploadsOf&) = delete;

 private:
  Layer& layer_;
  const Device& device_;
  const uint64_t before_;
};

// Frames that are drawn together, unless they are given up.
class FramesTogether {
 public:
  explicit FramesTogether(AddsFrames& device) : device_(device) { device.beginSum(); }
  ~FramesTogether() { device_.cancelSum(); }
  FramesTogether(const FramesTogether&) = delete;
  FramesTogether& operator=(const FramesTogether&) = delete;

  AddsFrames::Sum draw() { return device_.endSum(kLeastOpacity); }

 private:
  AddsFrames& device_;
};

// Keeps the reports that every rank has.
void keepCommon(Team& team, std::vector<std::optional<FrameReport>>& reports) {
  Message mine;
  for (const auto& report : reports) mine.push_back(std::byte{report.has_value()});
  for (const Message& other : team.gatherAll(mine)) {
    SLUICE_CHECK_EQ(other.size(), mine.size());
    for (size_t i = 0; i < reports.size(); ++i)
      if (other[i] == std::byte{0}) reports[i].reset();
  }
}

// Ranks have parts in the picture's place, and the first one the picture.
uint64_t composedBytes(uint64_t part_bytes, PictureSize size) {
  return part_bytes + static_cast<uint64_t>(size.width) * static_cast<uint64_t>(size.height) *
                          kComposedPixelBytes;
}

// The cut that the frame would have with so much memory in place of `now_bytes`, of which each of
// so many ranks holds its share.
std::optional<CutOptions> cutAt(std::optional<CutOptions> cut, uint64_t memory_bytes,
                                uint64_t now_bytes, uint64_t ranks) {
  if (!cut) return cut;
  for (const PictureRow row : {PictureRow::kOne, PictureRow::kMore})
    if (cut->most_held_bytes == ranks * cutBytes(now_bytes, row)) {
      cut->most_held_bytes = ranks * cutBytes(memory_bytes, row);
      return cut;
    }
  return cut;
}

}  // namespace

std::vector<BesideShare> Scene::sharesOf(const FrameOptions& frame, const MoreBytes& more_bytes,
                                         uint64_t of_memory) const {
  FrameOptions of_all = frame;
  const uint64_t ranks = share ? static_cast<uint64_t>(share->team().ranks()) : 1;
  of_all.cut = cutAt(frame.cut, of_memory, memory_bytes, ranks);
  const PictureDemand picture = demandOf(frame);
  const uint64_t more = more_bytes(of_memory);
  std::vector<BesideShare> shares;
  std::vector<PageGeometry> pages;
  for (const Layer* layer : layers()) {
    MachineOptions own_machine = layer->machine;
    // 0 would mean half of the free memory (memoryBudget()).
    own_machine.memory_bytes = std::max<uint64_t>(1, of_memory / layers().size());
    const FrameOptions own = optionsOf(*layer, of_all);
    const IndexedVolume& of = layer->volume;
    const uint64_t others_bytes = othersBytes(of, layer->look.transfer, own, pool) + more +
                                  (frame.strips == Strips::kNever ? comparingBytes(of) : 0);
    BesideShare beside = besideShare(of, own_machine, own.partition, picture, others_bytes);
    if (layer->share) {
      const uint64_t part_bytes =
          partBytes(frame.size, layer->share->dealing(), own_machine.memory_bytes);
      beside.beside_bytes = others_bytes + composedBytes(part_bytes, frame.size);
      beside.pages = pageCount(own_machine, of, beside.beside_bytes);
    }
    pages.push_back(layer->page);
    pages.back().pages = beside.pages;
    shares.push_back(beside);
  }
  if (!blends()) return shares;
  std::vector<std::pair<const IndexedVolume*, PageGeometry*>> even;
  for (size_t i = 0; i < pages.size(); ++i) even.emplace_back(&layers()[i]->volume, &pages[i]);
  evenOutPages(even);
  for (size_t i = 0; i < pages.size(); ++i) shares[i].pages = pages[i].pages;
  return shares;
}

uint64_t Scene::needOfMemory(const FrameOptions& frame, const MoreBytes& more_bytes,
                             uint64_t of_memory) const {
  const std::vector<BesideShare> shares = sharesOf(frame, more_bytes, of_memory);
  uint64_t most = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    const Layer& layer = *layers()[i];
    PageGeometry page = layer.page;
    page.pages = shares[i].pages;
    const BufferNeeds needs = needsOf(layer.volume.step(), frame.partition, shares[i].beside_bytes);
    most = std::max(
        most, textureMemoryBytes(page, device->limits().texels) + leastBufferBytes(page, needs));
  }
  return most * shares.size();
}

uint64_t Scene::enoughForRanks(const FrameOptions& frame, const MoreBytes& more_bytes,
                               uint64_t least_bytes) const {
  uint64_t enough = least_bytes;
  for (const Layer* layer : layers())
    enough =
        std::max(enough, layers().size() * memoryOfAnyParts(frame.size, layer->share->dealing()));
  const auto needOf = [&](uint64_t memory) { return needOfMemory(frame, more_bytes, memory); };
  return needOf(enough) > enough ? leastMemoryBytes(needOf, enough) : enough;
}

FrameOptions Scene::optionsOf(const Layer& layer, const FrameOptions& options) const {
  if (more.empty()) return options;
  const auto all = layers();
  const auto place = static_cast<uint64_t>(std::ranges::find(all, &layer) - all.begin());
  FrameOptions own =
      frameOfChannel({&layer.volume, &layer.look.transfer}, looks(), combine, options);
  own.is_one_of_several = true;
  own.shades = layer.look.lit;
  if (look.flat_scale > 0) own.lighting.flat_share *= layer.look.flat_scale / look.flat_scale;
  // Waiting is shared out, unless all layers are drawn together.
  if (blends()) return own;
  if (own.time_limit_s) *own.time_limit_s /= static_cast<double>(all.size());
  if (options.watch)
    own.watch = [watch = options.watch, place, count = all.size()](uint64_t done, uint64_t total) {
      watch(place * total + done, count * total);
    };
  return own;
}

std::vector<LayerLook> Scene::looks() const {
  std::vector<LayerLook> looks;
  for (const Layer* layer : layers()) looks.push_back({&layer->volume, &layer->look.transfer});
  return looks;
}

Frame Scene::drawBlended(std::vector<LayerFrame>& parts) {
  std::vector<Session*> sessions;
  for (Layer* layer : layers()) sessions.push_back(layer->session.get());
  const Session::Parts made = Session::parts(sessions);
  std::vector<std::optional<FrameReport>> without_blocks;
  for (const Session::Part& part : made.of_sessions)
    without_blocks.push_back(
        part.visible->blocks.empty()
            ? std::optional(reportWithoutBlocks(*part.visible, part.options.step_vox))
            : std::nullopt);
  if (share) keepCommon(share->team(), without_blocks);
  // A medium of one channel is that channel's own frame.
  const auto has_blocks = [](const std::optional<FrameReport>& without) { return !without; };
  if (std::ranges::count_if(without_blocks, has_blocks) == 1)
    return drawOnly(without_blocks, parts);
  std::vector<FrameReport> reports;
  Frame frame = composed(*this, [&] { return blendedFrame(made, *device, reports); });
  parts.clear();
  const bool shows = !showsNothing(frame.picture);
  for (size_t i = 0; i < reports.size(); ++i) {
    layers()[i]->uploaded_bytes += reports[i].uploaded_bytes;
    parts.push_back({reports[i], shows && !without_blocks[i]});
  }
  return frame;
}

Frame Scene::drawOnly(const std::vector<std::optional<FrameReport>>& without_blocks,
                      std::vector<LayerFrame>& parts) {
  Frame frame;
  parts.clear();
  for (size_t i = 0; i < without_blocks.size(); ++i) {
    if (without_blocks[i]) {
      parts.push_back({*without_blocks[i], false});
      layers()[i]->session->passFrame();
      continue;
    }
    Layer& layer = *layers()[i];
    const UploadsOf counted(layer, *device);
    frame = nextFrame(layer);
    toUnitOf(volume.source->layout(), layer.volume.source->layout(), frame.picture.depth);
    parts.push_back({frame.report, !showsNothing(frame.picture)});
  }
  frame.report = parts.front().report;
  for (size_t i = 1; i < parts.size(); ++i) addLayer(frame.report, parts[i].report);
  return frame;
}

std::vector<std::optional<FrameReport>> Scene::layersWithoutBlocks() {
  std::vector<std::optional<FrameReport>> reports;
  for (Layer* layer : layers()) reports.push_back(layer->session->withoutBlocks());
  // A rank may have no block of a layer that others have blocks of, and then composes its picture
  // with them.
  if (share) keepCommon(share->team(), reports);
  return reports;
}

AddsFrames* Scene::addsTogether(const std::vector<std::optional<FrameReport>>& without_blocks) {
  auto* const adds = dynamic_cast<AddsFrames*>(device.get());
  if (adds == nullptr || share) return nullptr;
  const std::vector<Layer*> all = layers();
  size_t count = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    if (without_blocks[i]) continue;
    ++count;
    // A volume over the first one has a grid and a unit of its own.
    if (all[i]->volume.channel.is_over || !haveOneLayout(all[i]->volume, volume) ||
        !isSameGrid(all[i]->volume.source->layout(), volume.source->layout()) ||
        !all[i]->session->canDrawAtEnd())
      return nullptr;
  }
  return count > 1 ? adds : nullptr;
}

Frame Scene::drawLayers(std::vector<LayerFrame>& parts) {
  const Stopwatch watch;
  const std::vector<Layer*> all = layers();
  const std::vector<std::optional<FrameReport>> without_blocks = layersWithoutBlocks();
  parts.clear();
  parts.resize(all.size());
  std::optional<Frame> sum;
  std::optional<FramesTogether> together;
  if (AddsFrames* const adds = addsTogether(without_blocks)) together.emplace(*adds);
  for (size_t i = 0; i < all.size(); ++i) {
    LayerFrame& part = parts[i];
    // A layer without blocks costs no picture, but the last one gives it if no other does.
    if (without_blocks[i] && (sum || together || i + 1 < all.size())) {
      part.report = *without_blocks[i];
      all[i]->session->passFrame();
      continue;
    }
    const UploadsOf counted(*all[i], *device);
    Frame next = nextFrame(*all[i]);
    if (together) {
      part.report = next.report;
      if (!sum) sum = std::move(next);
      continue;
    }
    toUnitOf(volume.source->layout(), all[i]->volume.source->layout(), next.picture.depth);
    part = {next.report, !showsNothing(next.picture)};
    if (!sum) {
      sum = std::move(next);
      continue;
    }
    addPicture(sum->picture, next.picture, pool);
    device->reuse(std::move(next.picture));
  }
  if (together) {
    const Stopwatch drawing;
    auto [picture, shows] = together->draw();
    sum->picture = std::move(picture);
    const double draw_s = drawing.seconds();
    // The time goes to the first channel's report alone, so that the sum counts it once.
    const auto first =
        std::ranges::find_if_not(without_blocks, &std::optional<FrameReport>::has_value) -
        without_blocks.begin();
    parts[static_cast<size_t>(first)].report.stages.draw += draw_s;
    size_t frame = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      if (without_blocks[i]) continue;
      parts[i].shows_something = shows[frame++];
      all[i]->session->noteDrawnAtEnd(draw_s / static_cast<double>(shows.size()));
    }
  }
  // Layers add light, and a pixel's opacity cannot exceed 1.
  limitSum(sum->picture, pool);
  sum->report = parts.front().report;
  for (size_t i = 1; i < parts.size(); ++i) addLayer(sum->report, parts[i].report);
  sum->report.seconds = watch.seconds();
  return *std::move(sum);
}

std::vector<std::string> Scene::lookWarnings() const {
  std::vector<std::string> lines;
  for (const Layer* layer : layers())
    for (const std::string& warning : layer->look.warnings)
      lines.push_back(more.empty() ? warning : layer->volume.channel.title() + ": " + warning);
  if (!why_added.empty()) lines.push_back(why_added);
  return lines;
}

std::vector<std::string> Scene::standInNotes() const {
  std::vector<const IndexedVolume*> volumes;
  for (const Layer* layer : layers()) volumes.push_back(&layer->volume);
  return sluice::standInNotes(volumes);
}

std::string Scene::emptyLayers(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                               const IndexPass& pass) const {
  std::string line;
  if (!frame.shows_something || more.empty()) return line;
  for (size_t i = 0; i < frame.layers.size(); ++i) {
    const LayerFrame& part = frame.layers[i];
    const Layer& layer = *layers()[i];
    if (part.shows_something) continue;
    const bool is_series = layer.volume.source->layout().time_steps > 1;
    const std::string why = whyEmpty({layer.volume, is_series ? time : 0, layer.look.transfer,
                                      optionsOf(layer, options), part.report.missing_share},
                                     pass);
    line += fmt::format("{}{} shows nothing: {}", line.empty() ? "" : "; ",
                        layer.volume.channel.title(), why);
  }
  return line;
}

}  // namespace sluice
