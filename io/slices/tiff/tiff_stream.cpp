#include "io/slices/tiff/tiff_stream.h"

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// libtiff sizes its buffers from tags; a damaged one must fail instead of taking all memory.
constexpr tmsize_t kMaxAllocationBytes = tmsize_t{1} << 30;

size_t take(TiffStream& s, std::span<std::byte> out) {
  // Strips and tiles would only be copied once more.
  if (out.size() >= s.window.size()) return s.file.readSome(s.position, out);
  const bool inside = s.position >= s.window_at && s.position - s.window_at < s.window_size &&
                      out.size() <= s.window_size - (s.position - s.window_at);
  if (!inside) {
    s.window_at = s.position;
    s.window_size = s.file.readSome(s.position, s.window);
  }
  const size_t got = std::min(out.size(), s.window_size);
  std::copy_n(s.window.begin() + static_cast<ptrdiff_t>(s.position - s.window_at), got,
              out.begin());
  return got;
}

TiffStream& of(thandle_t handle) {
  return *static_cast<TiffStream*>(handle);
}
tmsize_t read(thandle_t handle, void* to, tmsize_t bytes) {
  TiffStream& s = of(handle);
  try {
    const size_t got = take(s, {static_cast<std::byte*>(to), static_cast<size_t>(bytes)});
    s.position += got;
    return static_cast<tmsize_t>(got);
    // libtiff is C: no exception may pass its frames.
  } catch (const std::exception& e) {
    if (s.failure.message.empty()) s.failure = {e.what(), true};
    return -1;
  }
}
tmsize_t write(thandle_t, void*, tmsize_t) {
  return -1;
}
toff_t seek(thandle_t handle, toff_t offset, int whence) {
  TiffStream& s = of(handle);
  if (whence == SEEK_CUR) offset += s.position;
  if (whence == SEEK_END) offset += s.file.sizeBytes();
  return s.position = offset;
}
int close(thandle_t) {
  return 0;
}
toff_t size(thandle_t handle) {
  return of(handle).file.sizeBytes();
}
int error(TIFF*, void* user, const char* module, const char* format, va_list arguments) {
  TiffStream& s = of(user);
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  // The first message names the cause, later ones what follows from it.
  std::string& message = s.failure.message;
  if (message.empty()) message = fmt::format("{}: {}", module == nullptr ? "" : module, text);
  std::replace(message.begin(), message.end(), '\n', ' ');
  return 1;  // handled: libtiff's own printing is left out
}
int warning(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  // libtiff replaces a size that cannot be right, and says so in no other way.
  if (std::string_view(text).find("StripByteCounts") != std::string_view::npos)
    of(user).strip_size_replaced = true;
  return 1;
}

}  // namespace

void TiffStream::failWith(const std::string& what) {
  auto [reason, is_of_reading] = std::exchange(failure, {});
  if (is_of_reading) fail("{}", reason);
  const std::string named = file.path() + ": ";
  if (reason.starts_with(named)) reason.erase(0, named.size());
  fail("{}: {}{}{}", file.path(), what, reason.empty() ? "" : ": ", reason);
}

TiffPtr openTiff(TiffStream& stream) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, error, &stream);
  TIFFOpenOptionsSetWarningHandlerExtR(options, warning, &stream);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMaxAllocationBytes);
  // "m": no memory map, for which no functions are given.
  TiffPtr tiff(TIFFClientOpenExt(stream.file.path().c_str(), "rm", &stream, read, write, seek,
                                 close, size, nullptr, nullptr, options));
  TIFFOpenOptionsFree(options);
  if (!tiff) stream.failWith("no readable TIFF");
  return tiff;
}

}  // namespace sluice
