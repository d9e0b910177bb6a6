#include "src/library/conversions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "src/base/error.h"
#include "src/base/looks/view_limits.h"
#include "src/library/checked_values.h"

namespace sluice {
namespace {

DeviceChoice deviceOf(RendererOptions::Device device) {
  switch (device) {
    case RendererOptions::Device::kAuto:
      return DeviceChoice::kAuto;
    case RendererOptions::Device::kGl:
      return DeviceChoice::kGl;
    case RendererOptions::Device::kCpu:
      return DeviceChoice::kCpu;
  }
  failRequest("device {}: no such device", static_cast<int>(device));
}

ViewName viewName(ViewOptions::From from) {
  switch (from) {
    case ViewOptions::From::kPlain:
      return ViewName::kPlain;
    case ViewOptions::From::kFront:
      return ViewName::kFront;
    case ViewOptions::From::kBack:
      return ViewName::kBack;
    case ViewOptions::From::kLeft:
      return ViewName::kLeft;
    case ViewOptions::From::kRight:
      return ViewName::kRight;
    case ViewOptions::From::kTop:
      return ViewName::kTop;
    case ViewOptions::From::kBottom:
      return ViewName::kBottom;
    case ViewOptions::From::kThreeQuarter:
      return ViewName::kThreeQuarter;
  }
  failRequest("view.from {}: no such view", static_cast<int>(from));
}

Framing framingOf(const ViewOptions::Framing& given) {
  for (const double value :
       {given.target[0], given.target[1], given.target[2], given.reach, given.right, given.up})
    requireFinite("view.framing", value);
  if (!(given.reach > 0)) failRequest("view.framing.reach {}: must be above 0", given.reach);
  return {vec(given.target), given.reach, given.right, given.up};
}

Box3 cropOf(const PictureOptions::Box& given, Vec3i dims) {
  const Box3 box{vec(given.lo), vec(given.hi)};
  if (box.empty() || !boxOf(dims).contains(box))
    failRequest(
        "crop {},{},{} to {},{},{}: must hold a voxel along each axis and lie within the volume's "
        "{} x {} x {}",
        box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z, dims.x, dims.y, dims.z);
  return box;
}

// Sets what a word of a list names; an empty one changes nothing.
template <class Value, class List>
void setByWord(const char* field, const std::string& word, const List& values, Value& held) {
  if (word.empty()) return;
  const auto at = std::ranges::find_if(
      values, [&](Value each) { return std::string_view(name(each)) == word; });
  if (at != std::ranges::end(values)) {
    held = *at;
    return;
  }
  std::string words;
  for (const Value each : values) words += (words.empty() ? "" : ", ") + std::string(name(each));
  failRequest("pipeline.{} \"{}\": expected one of {}", field, word, words);
}

void setLighting(const PictureOptions::Lighting& lighting, FrameOptions& options) {
  Lighting& light = options.lighting;
  if (lighting.key) {
    for (const double angle : *lighting.key) requireFinite("lighting.key", angle);
    const double degree = std::numbers::pi / 180;
    const double aside = (*lighting.key)[0] * degree, up = (*lighting.key)[1] * degree;
    light.lights[0].toward = {std::sin(aside) * std::cos(up), std::sin(up),
                              std::cos(aside) * std::cos(up)};
  }
  const auto set = [](const char* field, const std::optional<double>& share, double& held) {
    if (!share) return;
    if (!(*share >= 0 && *share <= 1)) failRequest("{} {}: must be from 0 to 1", field, *share);
    held = *share;
  };
  set("lighting.ambient", lighting.ambient, light.ambient);
  set("lighting.diffuse", lighting.diffuse, light.diffuse);
  set("lighting.specular", lighting.specular, light.specular);
  set("lighting.shadows", lighting.shadows, light.shadows);
  set("lighting.occlusion", lighting.occlusion, light.occlusion);
  set("lighting.depth_cueing", lighting.depth_cueing, options.depth_cueing);
}

}  // namespace

MachineOptions machineOptions(const RendererOptions& options) {
  MachineOptions machine;
  machine.device.device = deviceOf(options.device);
  machine.device.lent = options.screen;
  machine.memory_bytes = options.memory_bytes;
  machine.threads = checkedThreads(options.threads);
  const PipelineOptions& pipeline = options.pipeline;
  setByWord("gl", pipeline.gl, kGlChoices, machine.device.gl);
  setByWord("simd", pipeline.simd, kSimdTargets, machine.device.simd);
  setByWord("policy", pipeline.policy, onlinePolicies(), machine.policy);
  machine.seed = pipeline.seed;
  machine.pages = pipeline.pages;
  if (pipeline.pages) requirePowerOfTwo("pipeline.pages", *pipeline.pages, 1, kMostCachePages);
  return machine;
}

void setPipeline(const PipelineOptions& pipeline, FrameOptions& options) {
  setByWord("algorithm", pipeline.algorithm, kAlgorithms, options.algorithm);
  setByWord("merge", pipeline.merge, kMergeOrders, options.merge_order);
  setByWord("partition", pipeline.partition, kPartitions, options.partition);
  setByWord("occlusion", pipeline.occlusion, kOcclusions, options.occlusion);
  if (options.occlusion != Occlusion::kOff && !traitsOf(options.mode).has_colors)
    failRequest("pipeline.occlusion {}: only composite pictures have opacity that hides",
                pipeline.occlusion);
  // Growing boxes exist for the finest level alone.
  if (options.partition == Partition::kBoxes && options.cut) {
    if (!options.cut->is_default || options.cut->keeps_thin)
      failRequest(
          "pipeline.partition boxes draws the finest level alone; leave out level, pixel_error, "
          "max_bytes and keep_thin");
    options.cut.reset();
  }
}

Mode modeOf(const LookOptions& look) {
  switch (look.mode) {
    case LookOptions::Mode::kComposite:
      return Mode::kComposite;
    case LookOptions::Mode::kMaximum:
      return Mode::kMip;
    case LookOptions::Mode::kMinimum:
      return Mode::kMinip;
    case LookOptions::Mode::kAverage:
      return Mode::kAverage;
    case LookOptions::Mode::kAttenuatedMaximum:
      return Mode::kAttenuatedMip;
    case LookOptions::Mode::kDepthMaximum:
      return Mode::kDepthMip;
  }
  failRequest("mode {}: no such mode", static_cast<int>(look.mode));
}

LookArguments lookArguments(const LookOptions& look, bool whole_series) {
  LookArguments arguments;
  arguments.first_picture = true;
  arguments.this_step = !whole_series;
  setLook(look, arguments);
  return arguments;
}

void setLook(const LookOptions& look, LookArguments& arguments) {
  if (look.threshold) {
    requireFinite("threshold", *look.threshold);
    arguments.threshold = look.threshold;
  }
  if (look.opacity) {
    if (!(*look.opacity >= 0 && *look.opacity <= 1))
      failRequest("opacity {}: must be from 0 to 1", *look.opacity);
    arguments.opacity = look.opacity;
  }
  if (!look.transfer_file.empty()) arguments.transfer_file = look.transfer_file;
  if (!look.map.empty()) arguments.map = look.map;
  if (!look.opacities.empty()) arguments.opacities.clear();
  for (const LookOptions::Opacity& point : look.opacities)
    arguments.opacities.push_back({point.value, point.opacity});
  if (!look.label_table.empty()) arguments.label_table = look.label_table;
  if (!look.label_looks.empty()) arguments.label_looks.clear();
  for (const LookOptions::Label& label : look.label_looks) {
    LabelLook own{label.first, label.last, label.color, label.opacity};
    // A look is valid only if a text can say it, as for channels below.
    if (parseLabelLook(labelLookText(own)) != own)
      failRequest(
          "label_looks: {}: expected whole labels that ascend, a colour and an opacity from 0 to 1",
          labelLookText(own));
    arguments.label_looks.push_back(std::move(own));
  }
  if (look.labels || !arguments.label_table.empty() || !arguments.label_looks.empty())
    arguments.labels = true;
  if (look.range) {
    for (const double end : *look.range) requireFinite("range", end);
    if ((*look.range)[0] == (*look.range)[1])
      failRequest("range {} to {}: must be two different values", (*look.range)[0],
                  (*look.range)[1]);
    arguments.range = {(*look.range)[0], (*look.range)[1]};
  }
  if (!look.channels.empty()) arguments.channels.clear();
  for (const LookOptions::Channel& channel : look.channels) {
    ChannelLook own{.channel = channel.channel, .map = channel.map, .opacity = channel.opacity};
    if (channel.range) own.range = {(*channel.range)[0], (*channel.range)[1]};
    // A look is valid only if a text can say it.
    if (parseChannelLook(channelLookText(own)) != own)
      failRequest(
          "channels: {}: expected a channel, a range of two different values and an opacity from "
          "0 to 1",
          channelLookText(own));
    arguments.channels.push_back(std::move(own));
  }
  if (look.combine)
    arguments.combine =
        *look.combine == LookOptions::Combine::kBlend ? Combine::kBlend : Combine::kAdd;
  if (!look.surfaces.empty()) arguments.surfaces.clear();
  for (const LookOptions::Surface& surface : look.surfaces) {
    SurfaceLook own{surface.value, surface.opacity, surface.color};
    if (parseSurfaceLook(surfaceLookText(own)) != own)
      failRequest("surfaces: {}: expected a finite value, an opacity from 0 to 1 and a colour",
                  surfaceLookText(own));
    arguments.surfaces.push_back(std::move(own));
  }
  if (arguments.surfaces.size() > kMostSurfaces)
    failRequest("surfaces: {} of them, at most {}", arguments.surfaces.size(), kMostSurfaces);
  if (look.attenuation) {
    if (!(*look.attenuation >= 0 && *look.attenuation <= kMostAttenuation))
      failRequest("attenuation {}: must be from 0 to {}", *look.attenuation, kMostAttenuation);
    arguments.attenuation = *look.attenuation;
  }
  if (look.light == LookOptions::Light::kOn) arguments.shade = true;
  if (look.light == LookOptions::Light::kOff) arguments.no_shade = true;
  if (look.full_gradient) {
    requireFinite("full_gradient", *look.full_gradient);
    if (!(*look.full_gradient > 0))
      failRequest("full_gradient {}: must be above 0", *look.full_gradient);
    arguments.modulate = true;
    arguments.full_gradient = *look.full_gradient;
  }
}

LookOptions lookOptionsOf(const LookArguments& arguments, Mode mode) {
  LookOptions look;
  for (const LookOptions::Mode each :
       {LookOptions::Mode::kComposite, LookOptions::Mode::kMaximum, LookOptions::Mode::kMinimum,
        LookOptions::Mode::kAverage, LookOptions::Mode::kAttenuatedMaximum,
        LookOptions::Mode::kDepthMaximum})
    if (LookOptions of{.mode = each}; modeOf(of) == mode) look.mode = each;
  look.threshold = arguments.threshold;
  look.opacity = arguments.opacity;
  look.transfer_file = arguments.transfer_file;
  look.map = arguments.map;
  for (const OpacityPoint& point : arguments.opacities)
    look.opacities.push_back({point.value, point.opacity});
  look.labels = arguments.labels;
  look.label_table = arguments.label_table;
  for (const LabelLook& label : arguments.label_looks)
    look.label_looks.push_back({label.first, label.last, label.color, label.opacity});
  const auto rangeOf = [](const std::optional<ValueRange>& range) {
    return range ? std::optional(std::array{range->lo, range->hi}) : std::nullopt;
  };
  look.range = rangeOf(arguments.range);
  for (const ChannelLook& channel : arguments.channels)
    look.channels.push_back(
        {channel.channel, channel.map, rangeOf(channel.range), channel.opacity});
  if (arguments.combine)
    look.combine = *arguments.combine == Combine::kBlend ? LookOptions::Combine::kBlend
                                                         : LookOptions::Combine::kAdd;
  for (const SurfaceLook& surface : arguments.surfaces)
    look.surfaces.push_back({surface.value, surface.opacity, surface.color});
  look.attenuation = arguments.attenuation;
  if (arguments.shade) look.light = LookOptions::Light::kOn;
  if (arguments.no_shade) look.light = LookOptions::Light::kOff;
  if (arguments.modulate) look.full_gradient = arguments.full_gradient;
  return look;
}

Camera cameraOf(const ViewOptions& view) {
  Camera camera;
  camera.view = viewName(view.from);
  camera.projection = view.projection == ViewOptions::Projection::kPerspective
                          ? Projection::kPerspective
                          : Projection::kOrtho;
  if (view.up) camera.up = vec(*view.up);
  camera.azimuth_deg = view.azimuth_deg;
  camera.elevation_deg = view.elevation_deg;
  camera.zoom = view.zoom;
  camera.field_of_view_deg = view.field_of_view_deg;
  if (view.framing) camera.framing = framingOf(*view.framing);
  if (view.look_at)
    camera.look_at = Camera::LookAt{vec(view.look_at->eye), vec(view.look_at->target)};
  return camera;
}

FitChoice fitChoice(const ViewOptions& view) {
  if (!view.fit) return std::nullopt;
  switch (*view.fit) {
    case ViewOptions::Fit::kVisible:
      return Fit::kVisible;
    case ViewOptions::Fit::kVolume:
      return Fit::kVolume;
  }
  failRequest("view.fit {}: no such fit", static_cast<int>(*view.fit));
}

ViewOptions::Framing framingOf(const Framing& framing) {
  return {asArray(framing.target), framing.reach, framing.right, framing.up};
}

void setDrawing(const PictureOptions& picture, FrameOptions& options) {
  using Quality = PictureOptions::Quality;
  if (picture.step_vox) options.step_vox = *picture.step_vox;
  options.integrates = picture.quality != Quality::kPlain;
  options.step_factor = picture.quality == Quality::kFast   ? 2
                        : picture.quality == Quality::kHigh ? 0.5
                                                            : 1;
  if (picture.jitter) {
    if (!(*picture.jitter >= 0 && *picture.jitter <= 1))
      failRequest("jitter {}: must be from 0 to 1", *picture.jitter);
    options.jitter = *picture.jitter;
  }
  setLighting(picture.lighting, options);
  if (picture.opacity_threshold) {
    if (!(*picture.opacity_threshold > 0 && *picture.opacity_threshold <= 1))
      failRequest("opacity_threshold {}: must be above 0, up to 1", *picture.opacity_threshold);
    options.opacity_threshold = picture.opacity_threshold;
  }
  if (picture.time_limit_s) {
    requireFinite("time_limit_s", *picture.time_limit_s);
    if (*picture.time_limit_s < 0)
      failRequest("time_limit_s {}: must be 0 or more", *picture.time_limit_s);
    options.time_limit_s = picture.time_limit_s;
  }
}

std::optional<CutOptions> askedCut(const PictureOptions& picture) {
  requireFinite("pixel_error", picture.pixel_error);
  if (!(picture.pixel_error > 0))
    failRequest("pixel_error {}: must be above 0", picture.pixel_error);
  if (picture.level && *picture.level < 0)
    failRequest("level {}: levels are counted from 0", *picture.level);
  // The finest level alone is no cut.
  if (picture.level == 0) return std::nullopt;
  CutOptions cut{.pixel_error = picture.pixel_error, .level = picture.level};
  // setPipeline() drops a cut that nobody asked for where boxes draw the finest level alone.
  cut.is_default = !picture.level && picture.max_bytes == 0;
  cut.keeps_thin = picture.keep_thin;
  if (picture.max_bytes != 0) cut.most_stored_bytes = picture.max_bytes;
  return cut;
}

FrameOptions frameOptions(const PictureOptions& picture, const VolumeLayout& layout, Mode mode) {
  FrameOptions options;
  options.camera = cameraOf(picture.view);
  options.size = {picture.width, picture.height};
  options.mode = mode;
  setDrawing(picture, options);
  resolve(options, layout);  // throws
  requireStep(picture.time, layout);
  options.cut = askedCut(picture);
  if (picture.crop) options.crop = cropOf(*picture.crop, layout.dims);
  if (picture.with_depth && !traitsOf(mode).has_colors)
    failRequest("with_depth: depth exists only in composite mode, since it is weighted by opacity");
  options.with_depth = picture.with_depth;
  if (picture.clip_planes.size() > kMostAskedPlanes)
    failRequest("clip_planes: {} of them, at most {}", picture.clip_planes.size(),
                kMostAskedPlanes);
  for (const PictureOptions::Plane& plane : picture.clip_planes) {
    for (const double value : {plane.normal[0], plane.normal[1], plane.normal[2], plane.offset})
      requireFinite("clip_planes", value);
    options.clip_planes.push_back({vec(plane.normal), plane.offset});
  }
  if (picture.next_time) requireStep(*picture.next_time, layout);
  return options;
}

}  // namespace sluice
