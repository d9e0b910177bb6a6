// StripFile: the PNG or OpenEXR file of a picture that comes strip by strip, from the top down.
//
// The folder: the files of a picture. exr_contents.h makes the contents of an OpenEXR file, and
// channel_traces.h names the traces of several channels.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "src/library/drawing/files/exr_contents.h"

namespace sluice {

enum class PictureKind { kPng, kExr };
// The kind by the name's extension in any case; nullopt: neither.
std::optional<PictureKind> pictureKind(const std::filesystem::path& path);

// Calls `take` with a few rows of the strip at a time, from the top down, and with the number of
// rows above them in the strip. So memory holds no second picture while a file is written. Throws
// Interrupted.
void eachFewRows(const Picture& strip, const StopToken& stop,
                 const std::function<void(const Picture& rows, int above)>& take);

// How a file shows a picture.
struct StripFileLook {
  std::optional<std::array<float, 3>> background;
  bool with_opacity = false;  // EXR: also the volume's own opacity
  // PNG: draws over rows that lie over their background already, from row `first` of the picture
  // on; empty: nothing.
  std::function<Picture(Picture rows, int first)> draw_over;
};

// The file has the same bytes whatever the strips. Without commit() nothing is left of it. One
// thread.
class StripFile {
 public:
  // `of` is the picture, whose inputs must outlive the file. Throws Error: neither kind, or the
  // file cannot be written.
  StripFile(const std::filesystem::path& path, StripFileLook look, const DrawnOf& of,
            StopToken stop);
  ~StripFile();
  StripFile(const StripFile&) = delete;
  StripFile& operator=(const StripFile&) = delete;

  // Adds the next rows. Throws Error, Interrupted.
  void add(const Picture& strip);
  // Finishes the file and gives it its name, with the same errors. Requires: all rows were added.
  void commit();

 private:
  void addRows(const Picture& rows);

  const std::filesystem::path path_;
  const StripFileLook look_;
  const DrawnOf of_;
  const StopToken stop_;
  int rows_done_ = 0;
  std::unique_ptr<PngFile> png_;  // null for the other kind
  std::unique_ptr<ExrFile> exr_;  // made with the first rows
};

}  // namespace sluice
