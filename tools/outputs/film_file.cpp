#include "tools/outputs/film_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/files/file_list.h"
#include "src/base/error.h"
#include "src/base/files/file_kind.h"

namespace sluice {
namespace {

// What ffmpeg is told: raw frames come in, an MP4 goes to `output`, its description before its
// frames, so that the start of the file says who made it. Sizes are made even, which most players
// need. The file exists already, under a temporary name without .mp4, so that -y and -f are needed.
// Without "file:" a colon in the name would stand behind a protocol.
std::vector<std::string> commandOf(const std::filesystem::path& output, PictureSize size,
                                   double frames_per_second) {
  return {"ffmpeg",
          "-hide_banner",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", size.width, size.height),
          "-framerate",
          fmt::format("{}", frames_per_second),
          "-i",
          "pipe:0",
          "-vf",
          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
          "-pix_fmt",
          "yuv420p",
          "-movflags",
          "+faststart",
          "-metadata",
          "comment=" + softwareMark(),
          "-f",
          "mp4",
          "file:" + std::filesystem::absolute(output).string()};
}

// Starts the command with `input` and `errors` as its streams, in a group of processes of its own:
// a Ctrl-C is ours to answer. 0 or an errno.
int spawn(pid_t& child, std::vector<std::string> words, int input, int errors) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  posix_spawn_file_actions_adddup2(&streams, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&streams, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&streams, errors, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failed =
      posix_spawnp(&child, arguments[0], &streams, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&streams);
  return failed;
}

// How a process ended; empty if it succeeded.
std::string endOf(int status) {
  if (WIFSIGNALED(status)) return fmt::format("it was ended by signal {}", WTERMSIG(status));
  const int exit_status = WEXITSTATUS(status);
  return exit_status == 0 ? "" : fmt::format("it ended with status {}", exit_status);
}

std::vector<std::byte> rgbOf(const Rgba8Picture& picture) {
  std::vector<std::byte> rgb;
  rgb.reserve(picture.rgba.size() / 4 * 3);
  for (size_t i = 0; i < picture.rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c) rgb.push_back(std::byte{picture.rgba[i + c]});
  return rgb;
}

}  // namespace

bool isFilmName(const std::filesystem::path& path) {
  return lowerExtension(path) == ".mp4";
}

std::string filmSizeNote(const std::filesystem::path& path, PictureSize size) {
  const auto even = [](int64_t side) { return side + side % 2; };
  if (size.width % 2 == 0 && size.height % 2 == 0) return "";
  return fmt::format(
      "{}: the film has {} x {} pixels, since films have even sides; the right column or the "
      "bottom "
      "row that --size lacks is black",
      path.string(), even(size.width), even(size.height));
}

FilmFile::FilmFile(const std::filesystem::path& path, PictureSize size, double frames_per_second,
                   StopToken stop)
    : path_(path),
      size_(size),
      frames_per_second_(frames_per_second),
      stop_(std::move(stop)),
      file_(path) {}

FilmFile::~FilmFile() {
  // An unfinished film is given up; file_ removes what ffmpeg wrote of it.
  if (child_ < 0) return;
  kill(child_, SIGKILL);
  // Without a wait the child stays a zombie as long as this process runs.
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void FilmFile::start() {
  std::array<int, 2> frames{}, messages{};
  // A socket, since writing to one whose reader has gone can be asked not to raise a signal.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, frames.data()) != 0)
    failErrno(fmt::format("{}: no socket to ffmpeg", path_.string()), errno);
  to_.reset(frames[0]);
  const Descriptor input(frames[1]);
  if (pipe2(messages.data(), O_CLOEXEC) != 0)
    failErrno(fmt::format("{}: no pipe from ffmpeg", path_.string()), errno);
  messages_.reset(messages[0]);
  const Descriptor errors(messages[1]);
  pid_t child = -1;
  const int failed = spawn(child, commandOf(file_.temporaryPath(), size_, frames_per_second_),
                           input.get(), errors.get());
  if (failed == ENOENT)
    fail(
        "{}: films are made by ffmpeg, which is not on the PATH; install ffmpeg, or write pictures "
        "with -o frame_%04d.png",
        path_.string());
  if (failed != 0) failErrno(fmt::format("{}: ffmpeg cannot be started", path_.string()), failed);
  child_ = child;
}

void FilmFile::send(std::span<const std::byte> bytes) {
  constexpr int kStepMs = 100;
  while (!bytes.empty()) {
    stop_.throwIfStopped();
    pollfd waiting{to_.get(), POLLOUT, 0};
    // Waits are short, so that an interruption is noticed while ffmpeg is slow.
    if (poll(&waiting, 1, kStepMs) <= 0) continue;
    const ssize_t sent = ::send(to_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (sent < 0) {
      awaitEnd();  // throws with the reason
      fail("{}: ffmpeg ended before the last frame", path_.string());
    }
    bytes = bytes.subspan(static_cast<size_t>(sent));
  }
}

void FilmFile::add(const Picture& rows) {
  if (child_ < 0) start();
  SLUICE_CHECK_EQ(rows.width, size_.width);
  SLUICE_CHECK_LE(rows.height, size_.height - rows_done_);
  send(rgbOf(toRgba8(over(rows, {0, 0, 0}))));
  rows_done_ = (rows_done_ + rows.height) % size_.height;
}

void FilmFile::awaitEnd() {
  to_.reset();  // the end of its input
  std::string said;
  constexpr int kStepMs = 100;
  for (std::array<char, 4096> buffer{};;) {
    stop_.throwIfStopped();
    pollfd waiting{messages_.get(), POLLIN, 0};
    if (poll(&waiting, 1, kStepMs) <= 0) continue;
    const ssize_t got = ::read(messages_.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    said.append(buffer.data(), static_cast<size_t>(got));
  }
  int status = 0;
  while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  while (!said.empty() && said.back() == '\n') said.pop_back();
  // It is asked for errors alone, and ends with status 0 after some, such as a full disk at the
  // end.
  if (said.empty()) said = endOf(status);
  for (size_t at = 0; (at = said.find('\n', at)) != std::string::npos;) said.replace(at, 1, "; ");
  if (!said.empty()) fail("{}: ffmpeg failed: {}", path_.string(), said);
}

void FilmFile::finish() {
  SLUICE_CHECK(child_ >= 0);
  SLUICE_CHECK_EQ(rows_done_, 0);
  awaitEnd();
  stop_.throwIfStopped();
  file_.commit();
}

}  // namespace sluice
