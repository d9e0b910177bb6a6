#include "tools/options/view_arguments.h"

#include <algorithm>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/library/conversions.h"

namespace sluice {

ViewedVolume viewedVolume(const VolumeArguments& volume, const ResourceArguments& resources,
                          const std::string& index_folder, bool whole_series) {
  ViewedVolume viewed{volume.inputs, volume.asked};
  VolumeOptions& options = viewed.options;
  options.whole_series = whole_series;
  options.time = volume.time;
  options.index_folder = index_folder;
  options.temporary_folder = volume.open.decode.folder;
  options.memory_bytes = resources.memory_bytes;
  options.threads = resources.threads;
  return viewed;
}

VolumeOptions::Web webOf(const WebOptions& web, const std::vector<std::string>& paths) {
  BucketAccess buckets = web.buckets;
  // Keys are looked for only if a bucket is named: a broken profile must not end other commands.
  if (web.find_buckets && std::ranges::any_of(paths, isBucketAddress)) buckets = web.find_buckets();
  VolumeOptions::Web options = webAccess(buckets);
  // A cache that was asked for and has no place would be left out without a word.
  if (web.cache.budget_bytes > 0 && web.cache.folder.empty()) failSystem("{}", kNoCacheFolder);
  options.cache_folder = web.cache.folder.string();
  options.cache_bytes = web.cache.budget_bytes;
  options.certificate_file = web.certificates.file;
  options.certificate_folder = web.certificates.folder;
  return options;
}

ViewState viewState(const ViewState& asked, const VolumeArguments& volume,
                    const LookArguments& look) {
  ViewState state = asked;
  state.time = volume.time;
  state.look.map = look.map;
  state.look.labels = look.labels;
  if (look.shade) state.look.light = LookOptions::Light::kOn;
  if (look.no_shade) state.look.light = LookOptions::Light::kOff;
  // The share means nothing to a look that does not follow gradients.
  if (look.modulate) state.look.full_gradient = look.full_gradient;
  return state;
}

RendererOptions rendererOptions(const ResourceArguments& resources) {
  RendererOptions options;
  options.memory_bytes = resources.memory_bytes;
  options.threads = resources.threads;
  options.pipeline.gl = name(resources.device.gl);
  switch (resources.device.device) {
    case DeviceChoice::kAuto:
      options.device = RendererOptions::Device::kAuto;
      break;
    case DeviceChoice::kGl:
      options.device = RendererOptions::Device::kGl;
      break;
    case DeviceChoice::kCpu:
      options.device = RendererOptions::Device::kCpu;
      break;
  }
  return options;
}

}  // namespace sluice
