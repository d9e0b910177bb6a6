#include "tools/commands/verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "src/library/drawing/scene/added_pictures.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/library/opening/shown_channels.h"
#include "src/library/opening/step_ranges.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/frame/pixel_rays.h"
#include "src/render/session/blended_frame.h"
#include "tools/command_line/progress_line.h"

namespace sluice {
namespace {

// More blocks would take gigabytes to list.
constexpr int64_t kMostBlocks = int64_t{1} << 22;

// All blocks, as if every value could be seen.
class EveryBlock : public BlockChooser {
 public:
  explicit EveryBlock(WorkerPool& pool) : pool_(pool) {}
  VisibleBlocksPtr choose(const BlockQuestion& question) override {
    const SliceRanges& ranges = *question.step.ranges;
    TransferFunction everything;
    everything.colors = {{0, {1, 1, 1}}};
    everything.opacities = {{0, 1}};
    const OpacityTable table(everything, ranges.map, ranges.device_range);
    return std::make_shared<const VisibleBlocks>(
        classify(ranges, table, question.crop, pool_, question.step.time));
  }

 private:
  WorkerPool& pool_;
};

// The volume as if nothing was known of it, in blocks of another size than the scene's.
// The bytes of the pictures in the memory of a session of the layer: those of all layers, or of
// this one, whose share of the memory it has.
uint64_t picturesBytes(const Scene& scene, const Layer& layer) {
  return (scene.blends() ? 1 : scene.layers().size()) * layer.part_bytes;
}

// `pictures_bytes`: those of the pictures, in addition to the volume.
IndexedVolume openAnew(const Layer& layer, ChannelSource opened, const VerifiedView& view,
                       uint64_t pictures_bytes, const IndexPass& pass) {
  MachineOptions machine = view.resources;
  machine.memory_bytes = memoryBudget(layer.machine);
  machine.block = comparedBlock(layer.volume.layout.size);
  machine.pages.reset();  // they need not hold a block of that size
  const IndexNeeds needs{.gradients = layer.volume.needs.gradients};
  IndexedVolume volume = indexVolume(std::move(opened.source), opened.arguments, machine, needs,
                                     {.disabled = true}, pass);
  volume.channel = std::move(opened.channel);
  volume.page.pages = pageCount(machine, volume, volume.rangesBytes() + pictures_bytes);
  return volume;
}

Picture blendedPicture(const std::vector<std::unique_ptr<Session>>& channels, Device& device) {
  std::vector<Session*> sessions;
  sessions.reserve(channels.size());
  for (const auto& channel : channels) sessions.push_back(channel.get());
  std::vector<FrameReport> reports;
  return blendedFrame(Session::parts(sessions), device, reports).picture;
}

// The channels of the scene in its order, with pages alike if they are blended.
std::vector<IndexedVolume> openAnew(const Scene& scene, const VerifiedView& view,
                                    const IndexPass& pass) {
  std::vector<ChannelSource> opened = openChannels(view.volume);
  const std::vector<const Layer*> layers = scene.layers();
  SLUICE_CHECK_EQ(opened.size(), layers.size());
  std::vector<IndexedVolume> volumes;
  for (size_t i = 0; i < layers.size(); ++i)
    volumes.push_back(
        openAnew(*layers[i], std::move(opened[i]), view, picturesBytes(scene, *layers[i]), pass));
  if (!scene.blends()) return volumes;
  std::vector<std::pair<const IndexedVolume*, PageGeometry*>> pages;
  pages.reserve(volumes.size());
  for (IndexedVolume& volume : volumes) pages.emplace_back(&volume, &volume.page);
  evenOutPages(pages);
  return volumes;
}

// A series has one range of values for all steps, which tables and light follow from.
TimeStep stepOf(const IndexedVolume& volume, const Layer& layer, int64_t time,
                const IndexPass& pass) {
  if (volume.source->layout().time_steps == 1) return volume.step();
  IndexedRanges ranges = rangesOfStep(volume, time, pass);
  ranges.ranges.device_range = layer.volume.index->ranges.device_range;
  const auto kept = std::make_shared<const IndexedRanges>(std::move(ranges));
  return {volume.source.get(), time, {kept, &kept->ranges}};
}

FrameOptions plainOptions(FrameOptions options) {
  options.algorithm = Algorithm::kConventional;
  options.partition = Partition::kBlocks;
  // Rays never end early.
  options.opacity_threshold = 1;
  options.occlusion = Occlusion::kOff;
  options.skipping = Skipping::kShading;
  options.time_limit_s.reset();
  options.cut.reset();
  options.count_samples = false;
  options.keep_phases = false;
  return options;
}

// The distance between slices that suits the finest levels of all.
double finestStep(const std::vector<IndexedVolume>& volumes, const FrameOptions& options) {
  const VolumeLayout& first = volumes.front().source->layout();
  double least = std::numeric_limits<double>::infinity();
  for (const IndexedVolume& volume : volumes) {
    const VolumeLayout& layout = volume.source->layout();
    const FrameOptions own = frameOn(layout, first, options);
    const View view = resolve(own, layout);
    least = std::min(least, stepOn(first, layout, stepFor(view, layout)));
  }
  return least;
}

// The rays of the picture's layer.
PixelRays raysOf(const VerifiedView& view, size_t layer) {
  return layer < view.layers.size() ? view.layers[layer].report.rays : PixelRays();
}

// Makes each pixel of `shown` the one of its rays that the rule of KeptRay takes. A plain loop of
// its own, since the loop of frames is among the things that are checked.
void takeRay(Picture& shown, const Picture& ray, KeptRay rule) {
  for (size_t i = 0; 4 * i < shown.rgba.size(); ++i) {
    float* const a = &shown.rgba[4 * i];
    const float* const b = &ray.rgba[4 * i];
    const float sign = rule == KeptRay::kDarkest ? -1.0F : 1.0F;
    const auto sum = [sign](const float* p) { return 4 * p[3] + sign * (p[0] + p[1] + p[2]); };
    const bool takes_all = rule != KeptRay::kEachChannel && sum(b) > sum(a);
    for (int c = 0; c < 4; ++c)
      if (rule == KeptRay::kEachChannel ? b[c] > a[c] : takes_all) a[c] = b[c];
  }
}

// The picture of one ray after the other of each pixel, which shows the most of them.
Picture pictureOfRays(Session& session, FrameOptions options, PixelRays rays) {
  Picture result;
  for (int y = 0; y < rays.a_side; ++y)
    for (int x = 0; x < rays.a_side; ++x) {
      options.ray_shift = shiftOfRay(x, y, rays.a_side);
      session.setOptions(options);
      Picture drawn = session.frame().picture;
      if (x == 0 && y == 0)
        result = std::move(drawn);
      else
        takeRay(result, drawn, rays.kept);
    }
  return result;
}

// The picture's options for the plain picture, fitted to the volumes anew. Adds to `unchecked`.
FrameOptions fittedOptions(const Scene& scene, const VerifiedView& view, FrameOptions options,
                           const std::vector<IndexedVolume>& volumes, const IndexPass& pass,
                           std::vector<std::string>& unchecked) {
  // Pictures of a cut have plain samples.
  if (drawsCut(scene.volume.step(), options.cut, options.mode, scene.look.transfer))
    options.integrates = false;
  options = plainOptions(std::move(options));
  std::vector<Camera> cameras = view.cameras;
  if (volumes.front().source->layout().time_steps == 1 || view.this_step) {
    const std::vector<const Layer*> layers = scene.layers();
    std::vector<FittedVolume> fitted;
    for (size_t i = 0; i < layers.size(); ++i)
      fitted.push_back({volumes[i], volumes[i].step(), layers[i]->look.transfer});
    const FitRequest request{std::move(fitted), options, true};
    fitCameras(cameras, view.fit, request, view.room, pass);
    options.shown_points = depthPoints(request, pass);
    options.camera = cameras.at(view.frame);
  } else {
    if (fitOf(cameras, view.fit) == Fit::kVisible)
      unchecked.emplace_back("the fit to all time steps");
    if (colorsByDepth(options)) unchecked.emplace_back("the depths of all time steps");
  }
  // Slices of the finest level lie closer than those of a picture from coarser ones.
  if (scene.volume.pyramid != nullptr && !view.has_step)
    options.step_vox = std::min(options.step_vox, finestStep(volumes, options));
  return options;
}

// `blocks`: null: those that the transfer function shows.
Picture plainPicture(Scene& scene, const VerifiedView& view, const FrameOptions& options,
                     const std::vector<IndexedVolume>& volumes, const IndexPass& pass,
                     BlockChooser* blocks) {
  const std::vector<Layer*> layers = scene.layers();
  std::optional<Picture> sum;
  std::vector<std::unique_ptr<Session>> blended;
  for (size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = *layers[i];
    // Blended channels are drawn together, each with its own share; others one after the other.
    SessionOptions session =
        sessionOptions(volumes[i], layer.look.lit, view.resources, Partition::kBlocks,
                       scene.blends() ? memoryBudget(layer.machine) : scene.memory_bytes);
    session.beside_bytes += picturesBytes(scene, layer);
    auto plain = std::make_unique<Session>(stepOf(volumes[i], layer, view.time, pass),
                                           *scene.device, scene.pool, session);
    plain->setTransferFunction(layer.look.transfer);
    plain->chooseBlocksBy(blocks);
    const PixelRays rays = raysOf(view, i);
    FrameOptions own = scene.optionsOf(layer, options);
    // Slices are no farther apart than rays.
    if (rays.a_side > 1 && !traitsOf(own.mode).on_planes) own.step_vox /= 2;
    plain->setOptions(own);
    if (scene.blends()) {
      blended.push_back(std::move(plain));
      continue;
    }
    Picture drawn = pictureOfRays(*plain, own, rays);
    if (!sum)
      sum = std::move(drawn);
    else
      addPicture(*sum, drawn, scene.pool);
  }
  if (scene.blends()) return blendedPicture(blended, *scene.device);
  if (layers.size() > 1) limitSum(*sum, scene.pool);
  return *std::move(sum);
}

void compare(const Picture& plain, const Picture& picture, Verification& result) {
  double sum = 0;
  for (size_t pixel = 0; pixel < plain.rgba.size(); pixel += 4) {
    double most = 0;
    for (size_t i = pixel; i < pixel + 4; ++i) {
      const double a = std::clamp(plain.rgba[i], 0.0F, 1.0F),
                   b = std::clamp(picture.rgba[i], 0.0F, 1.0F);
      const double difference = 255 * std::abs(a - b);
      most = std::max(most, difference);
      sum += difference;
    }
    result.max_difference = std::max(result.max_difference, most);
    // Rounding to 8 bits may differ by one.
    if (most > 1) ++result.differing_pixels;
  }
  result.mean_difference = sum / static_cast<double>(plain.rgba.size());
}

}  // namespace

Verification verify(Scene& scene, const VerifiedView& view, FrameOptions options,
                    const Picture& picture) {
  Verification result;
  result.unchecked.push_back(
      fmt::format("the choice of the look, how {} samples and lights", scene.device->backend()));
  // The plain picture has the memory of the other one.
  for (Layer* layer : scene.layers()) {
    layer->session.reset();
    layer->volume.source->holdAtMost(0);
  }
  ProgressMeter progress(view.resources.quiet ? ProgressWatch() : progressLine("verifying"));
  const IndexPass pass = passOf(scene, progress);
  const std::vector<IndexedVolume> volumes = openAnew(scene, view, pass);
  options = fittedOptions(scene, view, std::move(options), volumes, pass, result.unchecked);
  EveryBlock every_block(scene.pool);
  const bool all = volumes.front().layout.blockCount() <= kMostBlocks;
  if (!all) result.unchecked.emplace_back("which blocks are empty, since there are too many");
  // One rank draws the plain picture alone, and not a part of it.
  if (scene.share) scene.share->device().drawWhole(true);
  compare(plainPicture(scene, view, options, volumes, pass, all ? &every_block : nullptr), picture,
          result);
  return result;
}

}  // namespace sluice
