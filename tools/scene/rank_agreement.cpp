#include "tools/scene/rank_agreement.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <string_view>

#include "src/base/values/digest.h"
#include "src/parallel/agreement.h"
#include "src/render/session/planner.h"
#include "tools/outputs/report.h"

namespace sluice {
namespace {

// Options may differ that name files of a host or what a host has of its own.
constexpr std::array<std::string_view, 16> kOwn = {
    "volume", "transfer", "path",      "state", "basis", "memory", "threads", "device",
    "simd",   "gl",       "index-dir", "quiet", "force", "pages",  "cache",   "cache-dir"};

// Rows of voxels that are compared: for a single volume, and for each step of a series, where a row
// may cost a compressed chunk.
constexpr int kSceneSamples = 32, kStepSamples = 4;

// Converted to float, because hosts with other processors may compute the last bit of a double
// differently.
void add(Digest& digest, double number) {
  digest.add(static_cast<float>(number));
}

void add(Digest& digest, const std::vector<OpacityPoint>& points) {
  digest.add(points.size());
  for (const OpacityPoint& point : points) {
    add(digest, point.value);
    add(digest, point.opacity);
  }
}

uint64_t digestOf(const ChosenLook& look) {
  Digest digest;
  digest.add(look.transfer.colors.size());
  for (const ColorPoint& point : look.transfer.colors) {
    add(digest, point.value);
    for (int a = 0; a < 3; ++a) add(digest, point.rgb[a]);
  }
  add(digest, look.transfer.opacities);
  for (const GradientRow& row : look.transfer.gradients) {
    add(digest, row.magnitude);
    add(digest, row.factors);
  }
  digest.add(look.transfer.labels);
  digest.add(look.lit);
  return digest.value();
}

uint64_t digestOf(std::span<const Camera> cameras, const VolumeLayout& layout) {
  Digest digest;
  for (const Camera& camera : cameras) {
    const View view = resolve(camera, layout, {1, 1}, 1);
    for (const Vec3d& vector : {view.eye, view.right, view.up, view.forward})
      for (int a = 0; a < 3; ++a) add(digest, vector[a]);
    add(digest, view.half_height);
  }
  return digest.value();
}

// Exact positions of blocks: one block more or less would be a hole in the picture.
void addCuts(const Scene& scene, const Layer& layer, std::span<const Camera> cameras,
             FrameOptions options, Digest& digest) {
  const TimeStep step = layer.volume.step();
  ChunkNames names;
  Planner planner(layer.page, scene.pool, names);
  const LookPtr look = planner.look(
      step, std::make_shared<const TransferFunction>(layer.look.transfer), options.mode);
  for (const Camera& camera : cameras) {
    options.camera = camera;
    const FrameOptions own = scene.optionsOf(layer, options);
    const View view = resolve(own, step.source->layout());
    for (const ObjectBlock& block :
         planner.visibleBlocks(Planner::question(step, look, view, own))->blocks) {
      digest.add(block.name.level);
      digest.add(block.name.block);
      for (int a = 0; a < 3; ++a) {
        digest.add(block.cells.lo[a]);
        digest.add(block.cells.hi[a]);
      }
    }
  }
}

std::string adviceFor(const std::string& file) {
  return fmt::format("give every rank the same file; is {} an old copy on one host?", file);
}

// " of channel 1", if the scene shows several.
std::string ofWhich(const Scene& scene, const Layer& layer) {
  if (scene.more.empty()) return "";
  const ShownChannel& channel = layer.volume.channel;
  return channel.is_over ? " of --over" : fmt::format(" of channel {}", channel.number);
}

// "channel 1 of cells.ome.zarr", or the file's name if the layer is all that is shown of it.
std::string nameOf(const Scene& scene, const Layer& layer) {
  const ShownChannel& channel = layer.volume.channel;
  if (scene.more.empty() || channel.is_over) return layer.volume.name;
  return fmt::format("channel {} of {}", channel.number, layer.volume.name);
}

// "0,2,over": the same on all ranks, whatever the files' names are.
std::string listOfChannels(const Scene& scene) {
  std::string list;
  for (const Layer* layer : scene.layers())
    list += (list.empty() ? "" : ",") + layer->volume.channel.id();
  return list;
}

}  // namespace

void expectSameCommand(Team& team, const CLI::App& app) {
  const nlohmann::json options = optionsJson(app);
  // A rank with another command has other options altogether.
  expectAgreement(team, {{"sluice", SLUICE_VERSION}, {"the command", app.get_name()}},
                  "start the same command on every rank");
  std::vector<Fact> facts;
  for (const auto& [name, value] : options.items())
    if (name == "over")
      facts.push_back({"--over", "given"});  // the file may have another name
    else if (std::find(kOwn.begin(), kOwn.end(), name) == kOwn.end())
      facts.push_back({"--" + name, value.is_string() ? value.get<std::string>() : value.dump()});
  expectAgreement(team, facts, "start every rank with the same options");
}

void expectSameScene(Team& team, Scene& scene, std::span<const Camera> cameras,
                     const FrameOptions& options) {
  // As many statements follow as there are channels.
  expectAgreement(team, {{"the list of channels", listOfChannels(scene)}},
                  adviceFor(scene.volume.name));
  std::vector<Fact> looks{{"cameras", "", digestOf(cameras, scene.volume.source->layout())}};
  Digest cuts;
  for (const Layer* layer : scene.layers()) {
    const IndexedVolume& volume = layer->volume;
    expectAgreement(team, factsOf(*volume.source, volume.time, volume.index->ranges, kSceneSamples),
                    adviceFor(nameOf(scene, *layer)));
    looks.push_back({"transfer functions" + ofWhich(scene, *layer), "", digestOf(layer->look)});
    if (options.cut) addCuts(scene, *layer, cameras, options, cuts);
  }
  expectAgreement(team, looks, "give every rank the same files");
  expectAgreement(team, {{"levels of resolution", "", cuts.value()}},
                  "processors may round differently; give --level N");
}

void expectSameStep(Team& team, const Scene& scene, const std::vector<TimeStep>& steps) {
  const std::vector<const Layer*> layers = scene.layers();
  for (size_t i = 0; i < steps.size(); ++i) {
    const TimeStep& step = steps[i];
    // A second volume of one step shows in all of them, and was compared.
    if (step.source->layout().time_steps == 1) continue;
    expectAgreement(
        team, factsOf(*step.source, step.time, *step.ranges, kStepSamples),
        adviceFor(fmt::format("time step {} of {}", step.time, nameOf(scene, *layers[i]))));
  }
}

}  // namespace sluice
