// FilmFile: a film out of pictures, by ffmpeg as a child process that gets the frames through a
// socket. The film appears under its name when finish() returns, or never. One thread.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>

#include "src/base/atomic_file.h"
#include "src/base/descriptor.h"
#include "src/base/picture.h"
#include "src/base/stop_token.h"

namespace sluice {

// Whether a name ends in .mp4, in any case.
bool isFilmName(const std::filesystem::path& path);

class FilmFile {
 public:
  // Starts ffmpeg, which it looks for on the PATH. Throws Error: there is none, or the folder
  // cannot be written.
  FilmFile(const std::filesystem::path& path, double frames_per_second, StopToken stop);
  // Ends ffmpeg without a film, unless the film is finished.
  ~FilmFile();
  FilmFile(const FilmFile&) = delete;
  FilmFile& operator=(const FilmFile&) = delete;

  // The next frame; what is transparent is drawn over black. All frames have the first one's size.
  // Throws Error with ffmpeg's own line when it failed, and Interrupted.
  void add(const Picture& picture);
  // Throws Error. Requires: a frame.
  void finish();

 private:
  void start(int width, int height);
  void send(std::span<const std::byte> bytes);
  // Waits for ffmpeg's end; throws Error if it failed.
  void awaitEnd();

  const std::filesystem::path path_;
  const double frames_per_second_;
  const StopToken stop_;
  AtomicFile file_;
  Descriptor to_;        // ffmpeg's standard input
  Descriptor messages_;  // ffmpeg's standard error
  pid_t child_ = -1;     // -1: not running
  int width_ = 0, height_ = 0;
};

}  // namespace sluice
