#include "tools/outputs/picture_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>

#include "io/formats.h"
#include "src/annotate/annotate.h"
#include "src/base/files/numbered_name.h"
#include "src/base/sources/synth_name.h"
#include "src/base/values/letter_case.h"
#include "src/base/values/text_parts.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tools/command_line/interrupt.h"

namespace sluice {
namespace {

std::string labelName(const ChosenLook& look, double label) {
  const auto found = look.label_names.find(label);
  return found == look.label_names.end() ? fmt::format("{:.7g}", label) : found->second;
}

void addLabels(const Layer& layer, Annotations& annotations) {
  for (const ValueCount& entry : layer.volume.values.counts.entries)
    if (entry.lo == entry.hi && opacityAt(layer.look.transfer, entry.lo) > 0)
      annotations.legend.push_back(
          {labelName(layer.look, entry.lo), colorAt(layer.look.transfer, entry.lo)});
}

// A channel's own colour is the one of its brightest values. The map of a volume over another one
// ends in white, as that one's may, so that the middle tells more.
LegendEntry patchOf(const Layer& layer) {
  const ShownChannel& channel = layer.volume.channel;
  const TransferFunction& transfer = layer.look.transfer;
  const double lo = transfer.colors.front().value, hi = transfer.colors.back().value;
  return {channel.name.empty() ? channel.id() : channel.name,
          colorAt(transfer, channel.is_over ? std::midpoint(lo, hi) : hi)};
}

bool hasOpacity(const OpacityPoint& point) {
  return point.opacity > 0;
}

// A channel without opacity is switched off.
bool showsSomething(const TransferFunction& transfer) {
  return !transfer.surfaces.empty() || std::ranges::any_of(transfer.opacities, hasOpacity);
}

// The colours of a picture by depth: of world units behind the nearest part of what it shows.
void showDepths(std::array<double, 2> depths_shown, Annotations& annotations) {
  const auto [near, far] = depths_shown;
  annotations.range = {0, far - near};
  TransferFunction depths;
  const TransferFunction& look = annotations.transfer;
  const double first = look.colors.front().value, last = look.colors.back().value;
  for (size_t i = look.colors.size(); i-- > 0;) {
    const double share = last > first ? (last - look.colors[i].value) / (last - first) : 0;
    depths.colors.push_back({share * (far - near), look.colors[i].rgb});
  }
  depths.opacities = {{0, 1}, {far - near, 1}};
  annotations.transfer = std::move(depths);
}

// The values that a bar of colours is about: those that --range and the opacities give, whichever
// of the steps are known, or else all values of the volume.
ValueRange rangeOfBar(const Scene& scene) {
  const std::optional<ValueRange>& asked = scene.asked.range;
  const std::vector<OpacityPoint>& opacities = scene.look.transfer.opacities;
  if (!asked || opacities.empty()) return scene.volume.valueRange();
  return {std::min({asked->lo, asked->hi, opacities.front().value}),
          std::max({asked->lo, asked->hi, opacities.back().value})};
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
  annotations.transfer = scene.look.transfer;
  annotations.range = rangeOfBar(scene);
  if (traitsOf(options.mode).codes_depth)
    showDepths(shownDepths(annotations.view, layout, options), annotations);
  // Surfaces alone: no other value shows.
  const TransferFunction& transfer = scene.look.transfer;
  if (std::ranges::none_of(transfer.opacities, hasOpacity))
    for (const IsoSurface& surface : transfer.surfaces)
      annotations.legend.push_back({fmt::format("{:.7g}", surface.value), surface.rgb});
  for (const Layer* layer : scene.layers()) {
    if (layer->look.transfer.labels) {
      addLabels(*layer, annotations);
    } else if (!scene.more.empty() && showsSomething(layer->look.transfer)) {
      annotations.legend.push_back(patchOf(*layer));
    }
  }
  annotations.background = output.background;
  return annotations;
}

}  // namespace

std::optional<Aovs> parseAovs(std::string_view list) {
  Aovs aovs;
  if (list == "none") return aovs;
  for (const std::string_view word : split(list, ',')) {
    if (word != "depth" && word != "opacity") return std::nullopt;
    (word == "depth" ? aovs.depth : aovs.opacity) = true;
  }
  return aovs;
}

std::string pictureNameFor(const std::string& volume) {
  namespace fs = std::filesystem;
  std::string_view text = withoutSlashes(volume);
  if (isSynthSpec(text)) {
    text.remove_prefix(kSynthPrefix.size());
    text = text.substr(0, text.find(','));
  }
  const fs::path name = fs::path(text).filename();
  std::string result = name.stem().native();
  // "scan.nii.gz": the shortest of what endings of formats leave.
  for (const std::string& ending : volumeEndings())
    if (lowercase(name.native()).ends_with(ending))
      result = std::min(result, name.native().substr(0, name.native().size() - ending.size()),
                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  // "cells.ome.tif", "cells.ome.zarr".
  if (result.ends_with(".ome")) result.resize(result.size() - 4);
  // "step_%03d": a series, whose pictures may get numbers of their own.
  if (const auto series = parseNumberedName(result)) {
    result = series->before + series->after;
    while (result.ends_with('_') || result.ends_with('-')) result.pop_back();
  }
  // These would be the place of a number.
  for (char& c : result)
    if (c == '#' || c == '%') c = '_';
  if (result.empty() || result == "." || result == "..") result = "picture";
  return result + (name.extension() == ".png" ? "_drawn.png" : ".png");
}

Picture shownPicture(const Picture& picture, const PictureOutput& output,
                     const FrameOptions& options, const Scene& scene, int first_row) {
  Picture shown = output.background ? over(picture, *output.background) : picture;
  if (output.annotate) shown = annotated(shown, annotationsOf(output, options, scene), first_row);
  return shown;
}

PictureWriter::PictureWriter(const std::filesystem::path& path, const PictureOutput& output,
                             const FrameOptions& options, Scene& scene, FilmFile* film)
    : output_(output), options_(options), scene_(scene), film_(film) {
  if (film != nullptr) return;
  StripFileLook look{output.background, output.aovs.opacity, {}};
  if (output.annotate)
    look.draw_over = [this](const Picture& rows, int first) {
      return annotated(rows, annotationsOf(output_, options_, scene_), first);
    };
  file_.emplace(path, std::move(look),
                DrawnOf{options, *scene.volume.source, scene.look.transfer, scene.drawn_look},
                interruption());
}

PictureWriter::~PictureWriter() = default;

void PictureWriter::add(const Picture& strip) {
  if (file_) file_->add(strip);
  if (film_ != nullptr)
    eachFewRows(strip, interruption(), [&](const Picture& rows, int above) {
      film_->add(shownPicture(rows, output_, options_, scene_, film_rows_ + above));
    });
  film_rows_ += strip.height;
  scene_.noteMemory();
}

void PictureWriter::commit() {
  if (file_) file_->commit();
}

}  // namespace sluice
