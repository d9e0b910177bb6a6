// AtomicFile: a file that appears whole under its name or not at all.
//
// Writes go to "<path>.<n>.tmp" in the same folder (a long name is cut, see suffixedName()),
// locked; commit() flushes, syncs and renames it. The destructor removes a file that was not
// committed, so an exception or an interruption leaves nothing behind; removeTemporaries() does so
// when a signal ends the process. The next writer of the same path takes over what a killed process
// left. A path that is a symbolic link is followed, so that the link stays one. A path that is no
// regular file (/dev/null, a pipe with a reader) is written to directly, because it can be neither
// replaced nor restored. One thread an object; several objects, threads and processes may share a
// path.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "src/base/files/descriptor.h"
#include "src/base/files/temporary_name.h"

namespace sluice {

class AtomicFile {
 public:
  // Throws Error when the folder cannot be written, when the path is a folder itself, or when its
  // name is too long or has a zero byte.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Appends. Throws Error (path and reason, a full disk too).
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  // Writes from `offset` of the file on, for formats that fill in tables at the end; not to be
  // mixed with write(). Throws Error. Requires: a regular file.
  void writeAt(uint64_t offset, std::span<const std::byte> bytes);
  // The path to write to, for a library that opens the file by itself; commit() then renames it.
  const std::filesystem::path& temporaryPath() const { return temporary_; }
  // Throws Error; the old file, if any, stays as it was then.
  void commit();

 private:
  const std::filesystem::path path_;
  std::filesystem::path temporary_;  // path_ itself if that is no regular file
  Descriptor file_;
  std::optional<TemporaryName> name_;  // the name behind temporary_, unless temporary_ is path_
};

}  // namespace sluice
