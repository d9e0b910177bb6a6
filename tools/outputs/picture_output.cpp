#include "tools/outputs/picture_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/library/exr_contents.h"
#include "src/library/picture_memory.h"
#include "src/render/camera/index_space.h"
#include "tools/command_line/interrupt.h"

namespace sluice {
namespace {

// A picture of the rows [first, first + count), counted from the top.
Picture rowsFrom(const Picture& picture, int first, int count) {
  const auto width = static_cast<size_t>(picture.width), from = static_cast<size_t>(first) * width,
             pixels = static_cast<size_t>(count) * width;
  Picture rows{picture.width, count, {}, {}};
  const auto at = [](const std::vector<float>& values, size_t i) {
    return values.begin() + static_cast<int64_t>(i);
  };
  rows.rgba.assign(at(picture.rgba, 4 * from), at(picture.rgba, 4 * (from + pixels)));
  if (!picture.depth.empty())
    rows.depth.assign(at(picture.depth, from), at(picture.depth, from + pixels));
  return rows;
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

Picture shownPicture(const Picture& picture, const PictureOutput& output,
                     const FrameOptions& options, const Scene& scene, int first_row) {
  Picture shown = output.background ? over(picture, *output.background) : picture;
  if (output.annotate) shown = annotated(shown, annotationsOf(output, options, scene), first_row);
  return shown;
}

PictureWriter::PictureWriter(const std::filesystem::path& path, const PictureOutput& output,
                             const FrameOptions& options, Scene& scene, FilmFile* film)
    : path_(path), output_(output), options_(options), scene_(scene), film_(film) {
  if (film == nullptr && pictureKind(path) == PictureKind::kPng)
    png_ = std::make_unique<PngFile>(path, options.size.width, options.size.height, interruption());
}

PictureWriter::~PictureWriter() = default;

void PictureWriter::addExrRows(const Picture& rows) {
  if (exr_ != nullptr) {
    exr_->add(exrRows(rows, output_.background, output_.aovs.opacity));
    return;
  }
  const ExrContents first =
      exrContents(rows, output_.background, output_.aovs.opacity,
                  {options_, *scene_.volume.source, scene_.transfer, scene_.look.options});
  exr_ = std::make_unique<ExrFile>(path_, first, options_.size.height, ExrPrecision::kFloat,
                                   interruption());
  exr_->add(first);
}

void PictureWriter::addRows(const Picture& rows) {
  if (film_ != nullptr)
    film_->add(shownPicture(rows, output_, options_, scene_, rows_done_));
  else if (png_ != nullptr)
    png_->add(toRgba8(shownPicture(rows, output_, options_, scene_, rows_done_)));
  else
    addExrRows(rows);
}

void PictureWriter::add(const Picture& strip) {
  const auto width = static_cast<uint64_t>(strip.width);
  const int at_once = static_cast<int>(std::max<uint64_t>(1, kWrittenPixels / width));
  for (int first = 0; first < strip.height; first += at_once) {
    interruption().throwIfStopped();
    const int count = std::min(at_once, strip.height - first);
    addRows(rowsFrom(strip, first, count));
    rows_done_ += count;
  }
  scene_.noteMemory();
}

void PictureWriter::commit() {
  SLUICE_CHECK_EQ(rows_done_, options_.size.height);
  if (png_ != nullptr) png_->commit();
  if (exr_ != nullptr) exr_->commit();
}

}  // namespace sluice
