// FolderList: the entries of a folder that can be opened, as a dialog lists them. Reading it is one
// call that may take as long as its disk does; FolderReader makes it on a thread of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

struct FolderEntry {
  std::string name;        // shown name: the file's or the pattern's
  std::string path;        // path that opens it
  bool is_folder = false;  // to go into
  int64_t files = 1;       // files that the pattern of a series stands for
  friend bool operator==(const FolderEntry&, const FolderEntry&) = default;
};

struct FolderList {
  std::string folder;                // absolute
  std::vector<FolderEntry> entries;  // folders first, both by name
  std::string failure;               // one line if it cannot be read
};

// A question: visible folders and files whose names end in one of `ends` (lower case, dots
// included; names in any case). Folders whose names end so are opened as volumes, not entered. With
// `joins_series` files whose names differ in one number alone are one entry, "step_%03d.nrrd".
struct FolderQuestion {
  std::string folder;  // empty: the one that the program runs in
  std::vector<std::string> ends;
  bool joins_series = true;
  friend bool operator==(const FolderQuestion&, const FolderQuestion&) = default;
};
// Never throws; returns the entries read so far when `stop` asks for it.
FolderList readFolder(const FolderQuestion& question, const std::stop_token& stop = {});

// Names of files, in any order, with the files of a series joined. A pure function.
std::vector<FolderEntry> joinedSeries(std::vector<std::string> names);

// All members return at once, whatever the disk does, and may be called from any thread.
class FolderReader {
 public:
  // `on_list`: told, by the reader's thread, that there is something to take.
  explicit FolderReader(std::function<void()> on_list);
  // Waits for the call to the disk that is under way.
  ~FolderReader();
  FolderReader(const FolderReader&) = delete;
  FolderReader& operator=(const FolderReader&) = delete;

  // Replaces the question asked before.
  void ask(const FolderQuestion& question);
  // The newest question's, once.
  std::optional<FolderList> take();
  bool isReading() const;

 private:
  void answer(uint64_t number, const FolderQuestion& question, const std::stop_token& stop);

  const std::function<void()> on_list_;
  mutable Mutex mutex_;
  uint64_t asked_ SLUICE_GUARDED_BY(mutex_) = 0, answered_ SLUICE_GUARDED_BY(mutex_) = 0;
  std::optional<FolderList> list_ SLUICE_GUARDED_BY(mutex_);
  std::stop_source stop_ SLUICE_GUARDED_BY(mutex_);
  WorkerPool worker_{1};  // last: joins before the rest goes
};

}  // namespace sluice
