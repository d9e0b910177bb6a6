#include "src/library/drawing/files/exr_contents.h"

#include <fmt/format.h>

#include <utility>

#include "src/base/files/file_kind.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/render/camera/camera_matrices.h"
#include "src/render/camera/index_space.h"

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
    // The zoom that gives the framed height from the eye at zoom 1.
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

}  // namespace

ExrContents exrRows(const Picture& rows, const std::optional<std::array<float, 3>>& background,
                    bool with_opacity) {
  ExrContents exr{toLinearLight(background ? over(rows, *background) : rows)};
  if (!with_opacity) return exr;
  ExrChannel opacity{"opacity", {}};
  opacity.values.reserve(rows.rgba.size() / 4);
  for (size_t i = 3; i < rows.rgba.size(); i += 4) opacity.values.push_back(rows.rgba[i]);
  exr.channels.push_back(std::move(opacity));
  return exr;
}

ExrContents exrContents(const Picture& picture,
                        const std::optional<std::array<float, 3>>& background, bool with_opacity,
                        const DrawnOf& of) {
  const VolumeLayout& layout = of.source.layout();
  const FrameOptions& options = of.options;
  const View view = resolve(options, layout);
  ExrContents exr = exrRows(picture, background, with_opacity);
  const std::string unit = layout.unit.empty() ? "unknown" : layout.unit;
  exr.attributes = {{"camera", cameraText(options, view, layout)},
                    {"transferFunction", writeTransferFunction(of.transfer)},
                    {"look", of.look},
                    {"volume", of.source.identity()},
                    {"software", softwareMark()},
                    {"colors", "linear light, Rec. 709 primaries, premultiplied by A"},
                    {"worldUnit", unit}};
  if (!exr.picture.depth.empty()) {
    exr.attributes.emplace_back("depthMeaning",
                                "Z: distance from the eye along the view direction, in world "
                                "units, the mean of all samples weighted by what each adds to the "
                                "opacity");
    exr.attributes.emplace_back("depthWhereNothingIs", "infinity");
  }
  if (with_opacity)
    exr.attributes.emplace_back("opacityMeaning", "of the volume alone, without a background");
  exr.matrices = {{"worldToCamera", cameraFromWorld(view)}, {"worldToNDC", ndcFromWorld(view)}};
  exr.screen_window_width = screenWindowWidth(view);
  return exr;
}

}  // namespace sluice
