// FilmFile makes a film of pictures; ffmpeg runs as a child process that gets the frames through a
// socket. The film appears under its name when finish() returns, or never. One thread.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/files/atomic_file.h"
#include "src/base/files/descriptor.h"
#include "src/base/threads/stop_token.h"
#include "src/base/values/picture.h"
#include "src/device/view_values.h"

namespace sluice {

// Whether a name ends in .mp4, in any case.
bool isFilmName(const std::filesystem::path& path);

// The line about a film of this size, which differs from it if a side is odd; empty if it does not.
std::string filmSizeNote(const std::filesystem::path& path, PictureSize size);

class FilmFile {
 public:
  // `size` applies to all frames. Throws Error: the folder cannot be written.
  FilmFile(const std::filesystem::path& path, PictureSize size, double frames_per_second,
           StopToken stop);
  // Ends ffmpeg without a film, unless the film is finished.
  ~FilmFile();
  FilmFile(const FilmFile&) = delete;
  FilmFile& operator=(const FilmFile&) = delete;

  // The next rows, from the top of a frame down: a whole frame or a part of it. Transparent pixels
  // are drawn over black. The first rows start ffmpeg, which is looked for on the PATH. Throws
  // Error with ffmpeg's own line when it failed, and Interrupted. Requires: the frames' width, and
  // no more rows than the frame has left.
  void add(const Picture& rows);
  // Throws Error. Requires: a frame, and no part of one.
  void finish();

 private:
  void start();
  void send(std::span<const std::byte> bytes);
  // Waits for ffmpeg's end; throws Error if it failed.
  void awaitEnd();

  const std::filesystem::path path_;
  const PictureSize size_;
  const double frames_per_second_;
  const StopToken stop_;
  AtomicFile file_;
  Descriptor to_;        // ffmpeg's standard input
  Descriptor messages_;  // ffmpeg's standard error
  pid_t child_ = -1;     // -1: not running
  int rows_done_ = 0;    // rows of the frame that is being added
};

}  // namespace sluice
