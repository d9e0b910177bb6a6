#include "tools/picture_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/render/camera_matrices.h"
#include "src/render/index_space.h"

namespace sluice {
namespace {

// The options that give the camera again. A framing has none: it becomes the eye and the target
// that it led to.
std::string cameraText(const FrameOptions& options, const View& view, const VolumeLayout& layout) {
  Camera c = options.camera;
  if (c.framing) {
    const double distance = c.projection == Projection::kPerspective ? c.framing->reach : 1;
    c.look_at = Camera::LookAt{view.eye, view.eye + view.forward * distance};
    c.up = view.up;
    c.framing.reset();
    c.zoom = 1;
    c.zoom = resolve(c, layout, options.size, options.step_vox).half_height / view.half_height;
  }
  std::string text =
      fmt::format("--projection {} --zoom {} --fov {} --size {}x{} --step {}",
                  c.projection == Projection::kOrtho ? "ortho" : "perspective", c.zoom,
                  c.field_of_view_deg, options.size.width, options.size.height, options.step_vox);
  const auto triple = [](const char* option, Vec3d v) {
    return fmt::format(" {} {},{},{}", option, v.x, v.y, v.z);
  };
  if (c.up) text += triple("--up", *c.up);
  if (c.look_at)
    return text + triple("--eye", c.look_at->eye) + triple("--target", c.look_at->target);
  return text + fmt::format(" --view {} --fit volume --azimuth {} --elevation {}", name(c.view),
                            c.azimuth_deg, c.elevation_deg);
}

ExrContents exrOf(const Picture& shown, const Picture& drawn, const PictureOutput& output,
                  const FrameOptions& options, const Scene& scene) {
  const VolumeLayout& layout = scene.volume.source->layout();
  const View view = resolve(options.camera, layout, options.size, options.step_vox);
  ExrContents exr{toLinearLight(shown)};
  const std::string unit = layout.unit.empty() ? "unknown" : layout.unit;
  exr.attributes = {{"camera", cameraText(options, view, layout)},
                    {"transferFunction", writeTransferFunction(scene.transfer)},
                    {"look", scene.look.options},
                    {"volume", scene.volume.source->identity()},
                    {"software", std::string("sluice ") + SLUICE_VERSION},
                    {"colors", "linear light, Rec. 709 primaries, premultiplied by A"},
                    {"worldUnit", unit}};
  if (!exr.picture.depth.empty()) {
    exr.attributes.emplace_back("depthMeaning",
                                "Z: distance from the eye along the view direction, in world "
                                "units, the mean of all samples weighted by what each adds to the "
                                "opacity");
    exr.attributes.emplace_back("depthWhereNothingIs", "infinity");
  }
  if (output.aovs.opacity) {
    ExrChannel opacity{"opacity", {}};
    for (size_t i = 3; i < drawn.rgba.size(); i += 4) opacity.values.push_back(drawn.rgba[i]);
    exr.channels.push_back(std::move(opacity));
    exr.attributes.emplace_back("opacityMeaning", "of the volume alone, without a background");
  }
  exr.matrices = {{"worldToCamera", cameraFromWorld(view)}, {"worldToNDC", ndcFromWorld(view)}};
  exr.screen_window_width = screenWindowWidth(view);
  return exr;
}

Annotations annotationsOf(const PictureOutput& output, const FrameOptions& options,
                          const Scene& scene) {
  const VolumeLayout& layout = scene.volume.source->layout();
  const Camera& camera = options.camera;
  Annotations annotations;
  annotations.view = resolve(camera, layout, options.size, options.step_vox);
  annotations.target = worldFromIndex(layout, toDouble(layout.dims - Vec3i{1, 1, 1}) * 0.5);
  if (camera.framing) annotations.target = camera.framing->target;
  if (camera.look_at) annotations.target = camera.look_at->target;
  annotations.frame = layout.frame;
  annotations.unit = layout.unit;
  annotations.transfer = scene.transfer;
  annotations.range = scene.volume.valueRange();
  if (scene.transfer.labels)
    for (const ValueCount& entry : scene.volume.values.counts.entries)
      if (entry.lo == entry.hi && opacityAt(scene.transfer, entry.lo) > 0)
        annotations.labels.push_back(entry.lo);
  annotations.background = output.background;
  return annotations;
}

}  // namespace

std::optional<Aovs> parseAovs(std::string_view list) {
  Aovs aovs;
  if (list == "none") return aovs;
  while (true) {
    const size_t comma = list.find(',');
    const std::string_view word = list.substr(0, comma);
    if (word != "depth" && word != "opacity") return std::nullopt;
    (word == "depth" ? aovs.depth : aovs.opacity) = true;
    if (comma == std::string_view::npos) return aovs;
    list.remove_prefix(comma + 1);
  }
}

std::optional<PictureKind> pictureKind(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& letter : extension)
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  if (extension == ".png") return PictureKind::kPng;
  if (extension == ".exr") return PictureKind::kExr;
  return std::nullopt;
}

void writePicture(const std::filesystem::path& path, const Picture& picture,
                  const PictureOutput& output, const FrameOptions& options, const Scene& scene) {
  Picture shown = output.background ? over(picture, *output.background) : picture;
  if (pictureKind(path) == PictureKind::kExr) {
    writeExr(path, exrOf(shown, picture, output, options, scene), ExrPrecision::kFloat);
    return;
  }
  if (output.annotate) shown = annotated(shown, annotationsOf(output, options, scene));
  writePng(path, shown);
}

}  // namespace sluice
