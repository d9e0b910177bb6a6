// AtomicFile: a file that appears whole under its name or not at all.
//
// Writes go to "<path>.<n>.tmp" in the same folder, locked; commit() flushes, syncs and renames it.
// A file not committed is removed by the destructor, so an exception or an interruption leaves
// nothing behind (nor does removeTemporaries(), when a signal ends the process), and what a killed
// process left is taken over by the next that writes the same path. A path that is a symbolic link
// is followed, so that the link stays one. What is no regular file (/dev/null, a pipe that is read)
// is written to directly: it can be neither replaced nor taken back. One thread an object; several
// objects, threads and processes may share a path.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "src/base/descriptor.h"
#include "src/base/temporary_name.h"

namespace sluice {

class AtomicFile {
 public:
  // Throws Error when the folder cannot be written or the path is a folder itself.
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
  // Where a library wants a name to write to by itself; commit() then renames it.
  const std::filesystem::path& temporaryPath() const { return temporary_; }
  // Throws Error; the old file, if any, stays as it was then.
  void commit();

 private:
  const std::filesystem::path path_;
  std::filesystem::path temporary_;  // path_ itself where that is no regular file
  Descriptor file_;
  std::optional<TemporaryName> name_;  // of temporary_, unless that is path_
};

}  // namespace sluice
