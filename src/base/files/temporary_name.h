// TemporaryName: remembers the name of a temporary file, so that the file can be removed from a
// signal handler when the process has to end at once.
//
// AtomicFile has one for each of its files; nothing else needs it. A signal handler can reach only
// static data, so the names are kept in a fixed table of atomics. Any thread.
#pragma once

#include <filesystem>

namespace sluice {

class TemporaryName {
 public:
  // The file exists already. A name that is too long for the table, or comes when the table is
  // full, is not remembered.
  explicit TemporaryName(const std::filesystem::path& path);
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

 private:
  int slot_ = -1;  // in the table; -1: not remembered
};

// Deletes every file whose name is remembered. Async-signal-safe. Whoever calls it ends the process
// afterwards: a file that is made meanwhile may stay.
void removeTemporaries() noexcept;

}  // namespace sluice
