#include "src/library/drawing/files/strip_file.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/values/letter_case.h"
#include "src/library/drawing/cost/picture_memory.h"

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

}  // namespace

std::optional<PictureKind> pictureKind(const std::filesystem::path& path) {
  const std::string extension = lowercase(path.extension().string());
  if (extension == ".png") return PictureKind::kPng;
  if (extension == ".exr") return PictureKind::kExr;
  return std::nullopt;
}

void eachFewRows(const Picture& strip, const StopToken& stop,
                 const std::function<void(const Picture& rows, int above)>& take) {
  const auto width = static_cast<uint64_t>(strip.width);
  // A converted copy of a few rows at a time, so that writing takes a fixed amount of memory
  // (kWrittenPixels).
  const int at_once = static_cast<int>(std::max<uint64_t>(1, kWrittenPixels / width));
  for (int first = 0; first < strip.height; first += at_once) {
    stop.throwIfStopped();
    take(rowsFrom(strip, first, std::min(at_once, strip.height - first)), first);
  }
}

StripFile::StripFile(const std::filesystem::path& path, StripFileLook look, const DrawnOf& of,
                     StopToken stop)
    : path_(path), look_(std::move(look)), of_(of), stop_(std::move(stop)) {
  const std::optional<PictureKind> kind = pictureKind(path);
  if (!kind) failRequest("{}: pictures are written as .png or .exr", path.string());
  const PictureSize size = of.options.size;
  if (kind == PictureKind::kPng)
    png_ = std::make_unique<PngFile>(path, size.width, size.height, stop_);
}

StripFile::~StripFile() = default;

void StripFile::addRows(const Picture& rows) {
  if (png_ != nullptr) {
    Picture shown = look_.background ? over(rows, *look_.background) : rows;
    if (look_.draw_over) shown = look_.draw_over(std::move(shown), rows_done_);
    png_->add(toRgba8(shown));
  } else if (exr_ != nullptr) {
    exr_->add(exrRows(rows, look_.background, look_.with_opacity));
  } else {
    // The attributes and channels of an EXR file are written before its rows, so the first rows
    // bring them.
    const ExrContents first = exrContents(rows, look_.background, look_.with_opacity, of_);
    exr_ = std::make_unique<ExrFile>(path_, first, of_.options.size.height, ExrPrecision::kFloat,
                                     stop_);
    exr_->add(first);
  }
  rows_done_ += rows.height;
}

void StripFile::add(const Picture& strip) {
  eachFewRows(strip, stop_, [this](const Picture& rows, int /*above*/) { addRows(rows); });
}

void StripFile::commit() {
  // A file that lacks rows must not take the place of a whole one.
  SLUICE_CHECK_EQ(rows_done_, of_.options.size.height);
  if (png_ != nullptr) png_->commit();
  if (exr_ != nullptr) exr_->commit();
}

}  // namespace sluice
