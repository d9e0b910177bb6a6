#include "tools/picture_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/library/exr_contents.h"
#include "src/render/index_space.h"
#include "tools/interrupt.h"

namespace sluice {
namespace {

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

Picture shownPicture(const Picture& picture, const PictureOutput& output,
                     const FrameOptions& options, const Scene& scene) {
  Picture shown = output.background ? over(picture, *output.background) : picture;
  if (output.annotate) shown = annotated(shown, annotationsOf(output, options, scene));
  return shown;
}

void writePicture(const std::filesystem::path& path, const Picture& picture,
                  const PictureOutput& output, const FrameOptions& options, const Scene& scene) {
  if (pictureKind(path) == PictureKind::kExr) {
    writeExr(path,
             exrContents(picture, output.background, output.aovs.opacity,
                         {options, *scene.volume.source, scene.transfer, scene.look.options}),
             ExrPrecision::kFloat, interruption());
    return;
  }
  writePng(path, shownPicture(picture, output, options, scene), interruption());
}

}  // namespace sluice
