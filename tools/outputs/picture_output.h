// How `render` writes a picture: as PNG, with annotations if asked for, or as EXR with the
// attributes that a compositing program needs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "src/library/drawing/files/strip_file.h"
#include "src/render/camera/frame_options.h"
#include "tools/outputs/film_file.h"
#include "tools/scene/open_scene.h"

namespace sluice {

// Channels of an EXR in addition to the picture's colour and alpha.
struct Aovs {
  bool depth = false;
  bool opacity = false;  // opacity of the volume alone, even over a background
};
// "depth,opacity", "none".
std::optional<Aovs> parseAovs(std::string_view list);

// The picture's name if the user gives none: that of the volume without its extensions, as PNG, in
// the current folder. `volume`: a file, a folder, an address or a synthetic volume.
std::string pictureNameFor(const std::string& volume);

struct PictureOutput {
  std::optional<std::array<float, 3>> background;
  bool annotate = false;  // PNG
  Aovs aovs;              // EXR
};

// The picture over its background and with its annotations, as PNG files and films show it.
// `picture` may be some of its rows, from `first_row` on, counted from the top.
Picture shownPicture(const Picture& picture, const PictureOutput& output,
                     const FrameOptions& options, const Scene& scene, int first_row = 0);

// The file of a picture that comes strip by strip, or the next frame of a film (strip_file.h). One
// thread.
class PictureWriter {
 public:
  // `options` are the frame's; they and `scene` must outlive it. With `film` the picture is the
  // film's next frame instead of a file `path`. Throws Error.
  PictureWriter(const std::filesystem::path& path, const PictureOutput& output,
                const FrameOptions& options, Scene& scene, FilmFile* film = nullptr);
  ~PictureWriter();
  PictureWriter(const PictureWriter&) = delete;
  PictureWriter& operator=(const PictureWriter&) = delete;

  // Adds the next rows. Throws Error, and Interrupted after a signal.
  void add(const Picture& strip);
  // Finishes the file and gives it its name, with the same errors. Requires: all rows were added.
  void commit();

 private:
  const PictureOutput output_;
  const FrameOptions& options_;
  Scene& scene_;
  FilmFile* const film_;
  int film_rows_ = 0;              // rows added so far
  std::optional<StripFile> file_;  // without a film
};

}  // namespace sluice
