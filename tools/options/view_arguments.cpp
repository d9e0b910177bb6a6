#include "tools/options/view_arguments.h"

namespace sluice {
namespace {

template <class T>
std::array<T, 3> asArray(Vec3<T> v) {
  return {v.x, v.y, v.z};
}

ViewOptions::From fromOf(ViewName view) {
  switch (view) {
    case ViewName::kPlain:
      return ViewOptions::From::kPlain;
    case ViewName::kFront:
      return ViewOptions::From::kFront;
    case ViewName::kBack:
      return ViewOptions::From::kBack;
    case ViewName::kLeft:
      return ViewOptions::From::kLeft;
    case ViewName::kRight:
      return ViewOptions::From::kRight;
    case ViewName::kTop:
      return ViewOptions::From::kTop;
    case ViewName::kBottom:
      return ViewOptions::From::kBottom;
    case ViewName::kThreeQuarter:
      break;
  }
  return ViewOptions::From::kThreeQuarter;
}

LookOptions::Mode modeOf(Mode mode) {
  switch (mode) {
    case Mode::kMip:
      return LookOptions::Mode::kMaximum;
    case Mode::kMinip:
      return LookOptions::Mode::kMinimum;
    case Mode::kAverage:
      return LookOptions::Mode::kAverage;
    case Mode::kComposite:
      break;
  }
  return LookOptions::Mode::kComposite;
}

ViewOptions viewOptions(const Camera& camera, const FitChoice& fit) {
  ViewOptions view;
  view.from = fromOf(camera.view);
  view.azimuth_deg = camera.azimuth_deg;
  view.elevation_deg = camera.elevation_deg;
  view.zoom = camera.zoom;
  view.projection = camera.projection == Projection::kPerspective
                        ? ViewOptions::Projection::kPerspective
                        : ViewOptions::Projection::kParallel;
  view.field_of_view_deg = camera.field_of_view_deg;
  if (camera.up) view.up = asArray(*camera.up);
  if (camera.look_at)
    view.look_at =
        ViewOptions::LookAt{asArray(camera.look_at->eye), asArray(camera.look_at->target)};
  if (fit) view.fit = *fit == Fit::kVolume ? ViewOptions::Fit::kVolume : ViewOptions::Fit::kVisible;
  return view;
}

}  // namespace

ViewedVolume viewedVolume(const VolumeArguments& volume, const ResourceArguments& resources,
                          const std::string& index_folder) {
  ViewedVolume viewed;
  viewed.paths = volume.inputs;
  VolumeOptions& options = viewed.options;
  const OpenOptions& open = volume.open;
  if (open.dims) options.dims = asArray(*open.dims);
  if (open.type) options.type = name(*open.type);
  options.big_endian = open.byte_order == std::endian::big;
  options.skip_bytes = open.skip_bytes;
  options.time_steps = open.time_steps;
  if (open.spacing) options.spacing = asArray(*open.spacing);
  options.grid = open.grid;
  options.channel = open.channel.number;
  options.channel_name = open.channel.name;
  options.time = volume.time;
  options.index_folder = index_folder;
  options.temporary_folder = open.decode.folder;
  options.memory_bytes = resources.memory_bytes;
  options.threads = resources.threads;
  return viewed;
}

LookOptions lookOptions(const LookArguments& look, Mode mode) {
  LookOptions options;
  options.mode = modeOf(mode);
  options.threshold = look.threshold;
  options.opacity = look.opacity;
  for (const OpacityPoint& point : look.opacities)
    options.opacities.push_back({point.value, point.opacity});
  options.transfer_file = look.transfer_file;
  options.labels = look.labels;
  options.map = look.map;
  if (look.range) options.range = std::array{look.range->lo, look.range->hi};
  if (look.shade) options.light = LookOptions::Light::kOn;
  if (look.no_shade) options.light = LookOptions::Light::kOff;
  if (look.modulate) options.full_gradient = look.full_gradient;
  return options;
}

ViewState viewState(const VolumeArguments& volume, const LookArguments& look,
                    const FrameOptions& frame, const FitChoice& fit, bool has_step) {
  ViewState state;
  state.view = viewOptions(frame.camera, fit);
  state.look = lookOptions(look, frame.mode);
  state.time = volume.time;
  if (has_step) state.step_vox = frame.step_vox;
  if (frame.crop)
    state.crop = PictureOptions::Box{asArray(frame.crop->lo), asArray(frame.crop->hi)};
  for (const WorldPlane& plane : frame.clip_planes)
    state.clip_planes.push_back({asArray(plane.normal), plane.offset});
  if (look.has_background) state.background = look.background;
  return state;
}

RendererOptions rendererOptions(const ResourceArguments& resources) {
  RendererOptions options;
  options.memory_bytes = resources.memory_bytes;
  options.threads = resources.threads;
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
